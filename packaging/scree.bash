# Completion of scree for bash. It asks the program for its verbs, options and settings, so that it knows what that knows.
_scree() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]}
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null |
      awk '$1 == "scree" && $2 ~ /^[a-z]+$/ {print $2} END {print "--version --help"}' | sort -u)" -- "$word")
  elif [ "$before" = --set ]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" explain --settings 2>/dev/null |
      sed -n '/^$/q; s/^| `\([a-z_.]*\)`.*/\1=/p')" -- "$word")
    compopt -o nospace
  elif [ "$before" = --summary ]; then
    mapfile -t COMPREPLY < <(compgen -W json -- "$word")
  elif [ "${word#-}" != "$word" ]; then
    mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null |
      grep -o -- '^  -[-a-z, ]*' | grep -o -- '-[-a-z]*' | sort -u)" -- "$word")
  fi # else names of files
}
complete -o default -F _scree scree
