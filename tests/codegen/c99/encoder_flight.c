/* SPDX-License-Identifier: MIT
 * Flies the exported observer `encoder` for 20 minutes at 120 rad/s, 20 rad/s up and down: a motor whose encoder counts
 * turns without end (encoder_model() of example_models.h). Prints a hash of all results and the largest errors of the
 * speed, for readings with all turns and for readings modulo the wrap. The hash must be the same for each build.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include <encoder.h>

enum { kStates = 4, kSamples = 1200000 };
static const double kPeriod = 1e-3, kWrap = 4096.0;
static const double kA[kStates][kStates] = {{0, 1, 0, 0}, {0, -0.1, 400, -1e4}, {0, -20, -500, 0}, {0, 0, 0, 0}};

/* Over one sample period, exactly: the series of exp(A h). */
static void discretise(double a[kStates][kStates], double b[kStates]) {
  double term[kStates][kStates], next[kStates][kStates];
  for (int i = 0; i < kStates; ++i) {
    b[i] = 0.0;
    for (int j = 0; j < kStates; ++j) a[i][j] = term[i][j] = i == j ? 1.0 : 0.0;
  }
  for (int k = 1; k < 30; ++k) {
    for (int i = 0; i < kStates; ++i) {
      b[i] += term[i][2] * 500.0 * kPeriod / k;
      for (int j = 0; j < kStates; ++j) {
        next[i][j] = 0.0;
        for (int l = 0; l < kStates; ++l) next[i][j] += term[i][l] * kA[l][j] * kPeriod / k;
      }
    }
    for (int i = 0; i < kStates; ++i)
      for (int j = 0; j < kStates; ++j) {
        term[i][j] = next[i][j];
        a[i][j] += term[i][j];
      }
  }
}

static uint64_t hash = 0xcbf29ce484222325U;
static void hash_bytes(const void* bytes, unsigned count) {
  for (unsigned i = 0; i < count; ++i) hash = (hash ^ ((const unsigned char*)bytes)[i]) * 0x100000001b3U;
}

/* Returns the largest error of the speed after 0.2 s, or -1 if a status is not OK or z leaves the domain. */
static double flown(int modulo) {
  double a[kStates][kStates], b[kStates], x[kStates] = {0.5, 120.0, 0.03, 0.0}, worst = 0.0;
  encoder_observer observer;
  discretise(a, b);
  encoder_init(&observer);
  for (int k = 0; k < kSamples; ++k) {
    const double voltage = 4.83 + 0.8 * sin(5e-3 * k), read = modulo ? remainder(x[0], kWrap) : x[0];
    const float y[encoder_NY] = {(float)read}, u[encoder_NU] = {(float)voltage};
    float x_hat[encoder_NX];
    const encoder_status status = encoder_step(&observer, y, u);
    if (status != encoder_OK || !encoder_in_domain(&observer)) return -1.0;
    encoder_estimate(&observer, x_hat);
    hash_bytes(observer.z, sizeof(observer.z));
    hash_bytes(observer.y, sizeof(observer.y));
    hash_bytes(x_hat, sizeof(x_hat));
    if (k > 200) worst = fmax(worst, fabs((double)x_hat[encoder_state_omega] - x[1]));
    double next[kStates];
    for (int i = 0; i < kStates; ++i) {
      next[i] = b[i] * voltage;
      for (int j = 0; j < kStates; ++j) next[i] += a[i][j] * x[j];
    }
    for (int i = 0; i < kStates; ++i) x[i] = next[i];
  }
  return worst;
}

int main(void) {
  const double modulo = flown(1), all = flown(0);
  printf("encoder %016llx, errors %.3f and %.3f rad/s\n", (unsigned long long)hash, modulo, all);
  return modulo >= 0.0 && modulo < 2.0 && all >= 0.0 && all < 6.0 ? 0 : 1;
}
