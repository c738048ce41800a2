// SPDX-License-Identifier: MIT
// A firmware that flies the inputs of its golden replay and logs the columns of trainer/app/replay/README.md. Include it
// after
//   #define NLO_NAME rig
//   #define NLO_SCALAR float
//   #define NLO_HEADING "alpha,load,dt,x1_hat,x2_hat,status,in_domain"
//   #define NLO_FORMAT "%.9g"
//   #define NLO_AND_U(sample) , (sample)->u  // empty without inputs
//   #define NLO_INPUTS 1                     // number of inputs
#include <stdio.h>

#define NLO_JOIN_(a, b) a##b
#define NLO_JOIN(a, b) NLO_JOIN_(a, b)
#define NLO_(word) NLO_JOIN(NLO_NAME, _##word)

int main(void) {
  NLO_(observer) observer;
  NLO_(init)(&observer);
  printf("%s\n", NLO_HEADING);
  for (unsigned k = 0; k < sizeof(NLO_(replay_samples)) / sizeof(NLO_(replay_samples)[0]); ++k) {
    const NLO_(replay_sample)* sample = &NLO_(replay_samples)[k];
    const int status = (int)(sample->dt_s > 0 ? NLO_(step_dt)(&observer, sample->y NLO_AND_U(sample), sample->dt_s)
                                              : NLO_(step)(&observer, sample->y NLO_AND_U(sample)));
    for (int j = 0; j < NLO_(NY); ++j) printf(NLO_FORMAT ",", (double)sample->y[j]);
#ifdef NLO_INPUTS
    for (int j = 0; j < NLO_INPUTS; ++j) printf(NLO_FORMAT ",", (double)sample->u[j]);
#endif
    if (sample->dt_s > 0) printf(NLO_FORMAT, (double)sample->dt_s);
    NLO_SCALAR x_hat[NLO_(NX)];
    NLO_(estimate)(&observer, x_hat);
    for (int i = 0; i < NLO_(NX); ++i) printf("," NLO_FORMAT, (double)x_hat[i]);
    printf(",%d,%d\n", status, NLO_(in_domain)(&observer));
  }
  return 0;
}
