/* SPDX-License-Identifier: MIT
 * The shortest program with libnlo-model. It reads a model's outputs (then its inputs) from stdin, one sample per line,
 * and writes estimates to stdout.   usage: estimate MODEL.json <readings >estimates
 *   cc -std=c99 estimate.c $(pkg-config --cflags --libs nlo-model) -o estimate
 */
#include <nlo_model.h>
#include <stdio.h>
#include <stdlib.h>

/* Reads `count` numbers; "nan" is a missing number. Returns 0 at the end of the file. */
static int read_numbers(double* to, int count) {
  int i;
  for (i = 0; i < count; ++i)
    if (scanf("%lf", &to[i]) != 1) return 0;
  return 1;
}

int main(int argc, char** argv) {
  nlo_model* model = argc == 2 ? nlo_model_from_file(argv[1]) : NULL;
  nlo_observer* observer = model == NULL ? NULL : nlo_observer_create(model, NLO_FLOAT);
  int ny, nu, nx, i, failed = 0;
  double* numbers;
  if (observer == NULL) {
    fprintf(stderr, "%s\n", argc == 2 ? nlo_last_error() : "usage: estimate MODEL.json");
    nlo_model_free(model);
    return 2;
  }
  ny = nlo_model_ny(model);
  nu = nlo_model_nu(model);
  nx = nlo_model_nx(model);
  numbers = calloc((size_t)(ny + nu + nx), sizeof *numbers);
  if (numbers == NULL) return 1;
  for (i = 0; i < nx; ++i)
    printf("%s [%s] ", nlo_model_channel_name(model, NLO_STATE, i), nlo_model_channel_unit(model, NLO_STATE, i));
  printf("status in_domain\n");
  while (!failed && read_numbers(numbers, ny + nu)) {
    const int status = nlo_observer_step(observer, numbers, numbers + ny);
    failed = status < 0 || nlo_observer_estimate(observer, numbers + ny + nu) < 0;
    for (i = 0; i < nx; ++i) printf("%.9g ", numbers[ny + nu + i]);
    printf("%s %d\n", nlo_status_text(status), nlo_observer_in_domain(observer));
  }
  if (failed) fprintf(stderr, "%s\n", nlo_last_error());
  free(numbers);
  nlo_observer_free(observer);
  nlo_model_free(model);
  return failed;
}
