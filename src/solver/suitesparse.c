/* What Fortran cannot know of SuiteSparse: how large the workspaces of CHOLMOD and KLU are and where they keep their switches, which
   differ between versions and stand in the headers alone. A workspace is NULL where there is no memory or the library refuses. */
#include <cholmod.h>
#include <klu.h>
#include <stdlib.h>

/* A workspace of CHOLMOD that prints nothing, since the caller says what goes wrong, and that factorises to L L^T: its L D L^T would
   take an indefinite matrix, without pivoting. */
cholmod_common *scree_cholmod_open(void)
{
  cholmod_common *common = calloc(1, sizeof *common);
  if (common && !cholmod_start(common)) {
    free(common);
    return NULL;
  }
  if (common) {
    common->print = 0;
    common->final_ll = 1;
  }
  return common;
}

/* Ends CHOLMOD and gives its workspace back. */
void scree_cholmod_close(cholmod_common *common)
{
  cholmod_finish(common);
  free(common);
}

/* A workspace of KLU that does not look for the blocks of a triangular form, as there are none. */
klu_common *scree_klu_open(void)
{
  klu_common *common = calloc(1, sizeof *common);
  if (common && !klu_defaults(common)) {
    free(common);
    return NULL;
  }
  if (common) common->btf = 0;
  return common;
}

/* Gives a workspace of KLU back. */
void scree_klu_close(klu_common *common)
{
  free(common);
}

/* The smallest pivot over the largest; 0 where KLU cannot tell. */
double scree_klu_least_pivot(klu_symbolic *symbolic, klu_numeric *numeric, klu_common *common)
{
  return klu_rcond(symbolic, numeric, common) ? common->rcond : 0.0;
}
