/* Times CHOLMOD on a matrix of a given pattern, for tools/bench.

   Standard input: n and the number of entries (int64), first entry of each column (n + 1, int32), row of each entry (int32), of the
   lower triangle with its diagonal, rows ascending. The values are those of a diagonally dominant matrix: what a Cholesky factor
   costs depends on the pattern alone.

   Standard output: n, entries, entries of the factor, processor seconds of one analysis, one factorisation and one solution, the
   last two the least of some rounds. */
#include <cholmod.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { LEAST_ROUNDS = 5 };
static const double ENOUGH = 0.2;        /* seconds of rounds, after which no other begins but the first ones */
static const double LEAST_ROUND = 0.001; /* seconds; a shorter one has its work doubled */

static double processor_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

static double least(double a, double b) { return a < b ? a : b; }

static int fail(const char *words) {
  fprintf(stderr, "bench_factor: %s\n", words);
  return 2;
}

/* Off the diagonal -1, on it one more than the others of its row. */
static void set_values(cholmod_sparse *A) {
  const int *first = A->p, *row = A->i;
  double *value = A->x;
  for (size_t j = 0; j < A->ncol; j++) value[first[j]] = 1;
  for (size_t j = 0; j < A->ncol; j++)
    for (int k = first[j] + 1; k < first[j + 1]; k++) {
      value[k] = -1;
      value[first[j]] += 1;
      value[first[row[k]]] += 1;
    }
}

int main(void) {
  int64_t size[2];
  if (fread(size, sizeof size, 1, stdin) != 1 || size[0] < 1 || size[1] < size[0])
    return fail("expected the number of unknowns and of entries");
  cholmod_common common;
  cholmod_start(&common);
  common.final_ll = 1; /* as scree asks for */
  cholmod_sparse *A = cholmod_allocate_sparse(size[0], size[0], size[1], 1, 1, -1, CHOLMOD_REAL, &common);
  if (!A || fread(A->p, sizeof(int), size[0] + 1, stdin) != (size_t)size[0] + 1 ||
      fread(A->i, sizeof(int), size[1], stdin) != (size_t)size[1] || !cholmod_check_sparse(A, &common))
    return fail("expected a lower triangle in compressed columns");
  set_values(A);

  double begun = processor_seconds();
  cholmod_factor *L = cholmod_analyze(A, &common);
  const double analysis = processor_seconds() - begun;
  cholmod_dense *b = cholmod_ones(size[0], 1, CHOLMOD_REAL, &common);
  if (!L || !b) return fail("no memory");

  double factorisation = 1e30, solution = 1e30, spent = 0;
  int repeats = 1; /* in a round, so that the clock can tell */
  for (int round = 0; round < LEAST_ROUNDS || spent < ENOUGH; round++) {
    begun = processor_seconds();
    for (int k = 0; k < repeats; k++)
      if (!cholmod_factorize(A, L, &common) || common.status != CHOLMOD_OK) return fail("the matrix is not definite");
    const double factorised = processor_seconds();
    for (int k = 0; k < repeats; k++) {
      cholmod_dense *x = cholmod_solve(CHOLMOD_A, L, b, &common);
      if (!x) return fail("no memory");
      cholmod_free_dense(&x, &common);
    }
    const double solved = processor_seconds();
    spent += solved - begun;
    if (solved - begun < LEAST_ROUND) {
      repeats *= 2;
      round = -1;
      continue;
    }
    factorisation = least(factorisation, (factorised - begun) / repeats);
    solution = least(solution, (solved - factorised) / repeats);
  }
  printf("%lld %lld %.0f %.6e %.6e %.6e\n", (long long)size[0], (long long)size[1], common.lnz, analysis, factorisation, solution);
  cholmod_free_dense(&b, &common);
  cholmod_free_factor(&L, &common);
  cholmod_free_sparse(&A, &common);
  cholmod_finish(&common);
  return 0;
}
