// tiny_c99: the observer that tiny_c99.h declares, generated. Do not edit.
// Each sum is taken in the order of its terms, and each operation is rounded by itself. So the bits
// are the same on every IEEE 754 target, for every compiler and at every optimisation level. They
// are those of the C++ runtime's deterministic policy. clang's -ffp-contract=fast and any
// -ffast-math change them. No library is referenced: no libm, no memcpy, no heap.
#include "tiny_c99.h"

#include <float.h>

#if tiny_c99_EXPORT != 0xc877343a
#error "tiny_c99.h and tiny_c99.c are not of one export: copy both"
#endif

// An x87 computes with more digits than a float or double has.
#if defined(FLT_EVAL_METHOD) && ((FLT_EVAL_METHOD < 0) || (FLT_EVAL_METHOD == 1) || (FLT_EVAL_METHOD == 2))
#error "FLT_EVAL_METHOD must be 0, else results have other bits: for x86 compile with -msse2 -mfpmath=sse"
#endif

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off", "no-tree-loop-distribute-patterns", "no-tree-vectorize")
#else
#pragma STDC FP_CONTRACT OFF
#endif

// The flash of an AVR has its own address space, so pointers to constants have their own type.
#if !defined(__AVR__)
#define IN_FLASH
#define REGULAR_STEP (&kStep)
#elif defined(__FLASH) && !defined(__STRICT_ANSI__)
// avr-gcc 5 would merge two tables with equal values, and warn.
#pragma GCC optimize("no-ipa-icf")
#define IN_FLASH __flash
#define REGULAR_STEP ((const Step[]){kStep})  // a copy in RAM, as for a step that is computed
#else
#error "constants in the flash of an AVR: compile with -std=gnu99 or later, as the Arduino IDE does"
#endif

// Static analysers assume that a volatile object may hold any value.
#if defined(__FRAMAC__)
#define EACH_STORE
#else
#define EACH_STORE volatile
#endif

typedef float Scalar;

enum { kNx = 1, kNy = 1, kNz = 2 };

typedef union {
  Scalar value;
  uint32_t bits;
} Both;

static uint32_t bits_of(Scalar value) {
  Both both;
  both.value = value;
  return both.bits;
}
static Scalar of_bits(uint32_t bits) {
  Both both;
  both.bits = bits;
  return both.value;
}

enum { kStaleAfter = 13, kLongestGap = 1000 };  // sample periods
static const Scalar kSamplePeriod = 0.02f;  // s
static const Scalar kLargest = 1.2676506e+30f;  // largest |z| from which a step cannot overflow
static const Scalar kTiny = 7.888609e-31f;  // a smaller |z| becomes 0

static const IN_FLASH Scalar kInitial[kNz] = {0.0f, 0.0f};  // z before the first measurement
static const IN_FLASH Scalar kNoOutput[kNy] = {0.0f};

// Ranges of the readings. The domain: the box of z in training.
static const IN_FLASH Scalar kOutputMin[kNy] = {-3.0f};
static const IN_FLASH Scalar kOutputMax[kNy] = {3.0f};
static const IN_FLASH Scalar kLatentMin[kNz] = {-4.0f, -1.0f};
static const IN_FLASH Scalar kLatentMax[kNz] = {4.0f, 1.0f};

// True if v is finite. It tests the bits, so that -ffast-math cannot remove the test. `v == v` is for static analysers.
static bool is_finite(Scalar value) { return (bits_of(value) & 0x7f800000U) != 0x7f800000U; }

// volatile, because compilers would turn the loop into a call of memcpy.
static void copy(Scalar* to, const Scalar* from, int n) {
  EACH_STORE Scalar* target = to;
  for (int i = 0; i < n; ++i) { target[i] = from[i]; }
}

static void load(Scalar* to, const IN_FLASH Scalar* from, int n) {
  EACH_STORE Scalar* target = to;
  for (int i = 0; i < n; ++i) { target[i] = from[i]; }
}

// Health of a channel. 0: its latest sample was used unchanged. Otherwise 4 n + b, where n counts the samples in a row
// that were not used unchanged.
//   b = 1  the last good value was used instead
//   b = 2  the sample was clamped
//   b = 3  the sample was clamped after missed samples
//   b = 0  the sample was used unchanged after missed samples; the next count starts at 1
static uint16_t counted_on(uint16_t last, uint16_t samples, uint16_t what) {
  const uint32_t before = ((last % 4U) != 0U) ? ((uint32_t)last / 4U) : 0U, all = before + samples, most = 16383U;
  return (uint16_t)((((all < most) ? all : most) * 4U) + what);
}
static bool is_clamped(uint16_t health) { return ((health / 2U) % 2U) != 0U; }
static tiny_c99_status status_of_health(uint16_t health) {
  const bool late = (health / 4U) >= (uint16_t)kStaleAfter;
  if (health == 0U) { return tiny_c99_OK; }
  if (late && is_clamped(health)) { return tiny_c99_OUT_OF_RANGE; }
  if (late) { return tiny_c99_STALE; }
  if ((health % 4U) == 2U) { return tiny_c99_CLAMPED; }
  return tiny_c99_HELD;
}

// Validates the readings of a sample. `accepted` holds the last good readings; usable values overwrite them. Updates
// the health of each channel. Returns true if a reading was held.
static bool validate(const Scalar* y, Scalar* accepted, uint16_t* health) {
  bool held = false;
  for (int j = 0; j < kNy; ++j) {
    const bool finite = is_finite(y[j]);
    uint16_t now = 0U;
    if (finite && (y[j] == y[j]) && (y[j] >= kOutputMin[j]) && (y[j] <= kOutputMax[j])) {
      accepted[j] = y[j];
    } else if (finite) {
      accepted[j] = (y[j] < kOutputMin[j]) ? kOutputMin[j] : kOutputMax[j];
      now = counted_on(health[j], 1U, 2U);
    } else {
      now = counted_on(health[j], 1U, 1U);
      held = true;
    }
    health[j] = now;
  }
  return held;
}

// True if z is so small that a step cannot overflow. A larger z has been corrupted by a bit flip.
static bool is_reachable(const Scalar* z) {
  bool good = true;
  for (int r = 0; r < kNz; ++r) { good = good && is_finite(z[r]) && (z[r] == z[r]) && (z[r] > -kLargest) && (z[r] < kLargest); }
  return good;
}

// True if steps can lead to this state.
static bool is_sound(const tiny_c99_observer* o) {
  bool good = (o->started <= 1U) && is_reachable(o->z) &&
              ((o->status <= (uint8_t)tiny_c99_REJECTED) || (o->status == (uint8_t)tiny_c99_RESET));
  for (int j = 0; j < kNy; ++j) {
    const Scalar y = o->y[j];
    good = good && is_finite(y) && (y == y) && ((o->started != 1U) ? ((y <= 0.0f) && (y >= 0.0f)) :
        ((y >= kOutputMin[j]) && (y <= kOutputMax[j])));
  }
  return good;
}

static tiny_c99_status set_status(tiny_c99_observer* o, tiny_c99_status status) {
  o->status = (uint8_t)status;
  return status;
}

// Sets the status of a sample: the worst of its channels.
static tiny_c99_status update_status(tiny_c99_observer* o) {
  tiny_c99_status worst = tiny_c99_OK;
  for (int j = 0; j < kNy; ++j) {
    const tiny_c99_status status = status_of_health(o->health[j]);
    if (status > worst) { worst = status; }
  }
  return set_status(o, worst);
}

// exp(w) - 1, phi_1(w) = (exp(w) - 1) / w and phi_2(w) = (phi_1(w) - 1) / w: Taylor series at w / 2^s, then s doublings
// (Higham, Functions of Matrices, section 10.7.4). The number of doublings suffices for any w; NaN gives NaN.
// w <= 0.
static void phi(Scalar w, Scalar* exp_minus_1, Scalar* phi1, Scalar* phi2) {
  int doublings = 0;
  for (; (doublings < 130) && (w < -0.5f); ++doublings) { w *= 0.5f; }
  Scalar p2 = 1.0f;
  for (int k = 15; k >= 1; --k) { const int n = k + 2; p2 = (w * p2 * (1.0f / (Scalar)n)) + 1.0f; }
  p2 *= 0.5f;
  Scalar p1 = (w * p2) + 1.0f, e = w * p1;
  for (; doublings > 0; --doublings) {
    p2 = ((p1 * p1) + (p2 * 2.0f)) * 0.25f;
    p1 = p1 * (e + 2.0f) * 0.5f;
    e = e * (e + 2.0f);
  }
  *exp_minus_1 = e;
  *phi1 = p1;
  *phi2 = p2;
}

// out = W in + b. The weights are stored one neuron after another.
static void dense(int inputs, int outputs, const IN_FLASH Scalar* weights, const IN_FLASH Scalar* bias, const Scalar* in,
                  Scalar* out) {
  for (int fours = outputs / 4; fours > 0; --fours) {  // four sums at once: each input is loaded once for four weights
    const IN_FLASH Scalar *w0 = weights, *w1 = w0 + inputs, *w2 = w1 + inputs, *w3 = w2 + inputs;
    Scalar sum0 = bias[0], sum1 = bias[1], sum2 = bias[2], sum3 = bias[3];
    for (int i = 0; i < inputs; ++i) {
      const Scalar x = in[i];
      sum0 += w0[i] * x;
      sum1 += w1[i] * x;
      sum2 += w2[i] * x;
      sum3 += w3[i] * x;
    }
    out[0] = sum0;
    out[1] = sum1;
    out[2] = sum2;
    out[3] = sum3;
    weights = &weights[4 * inputs];
    bias = &bias[4];
    out = &out[4];
  }
  for (int rest = outputs % 4; rest > 0; --rest) {
    Scalar total = *bias++;
    for (int i = 0; i < inputs; ++i) { total += weights[i] * in[i]; }
    *out++ = total;
    weights = &weights[inputs];
  }
}

// Returns x P(x^2) / Q(x^2), degrees 9/8, with x clamped to +-7.75; its error is below 5e-7.
static Scalar tanh_rational(Scalar x) {
  const Scalar limit = 7.75f;
  x = (x < limit) ? x : limit;
  x = (x > -limit) ? x : -limit;
  const Scalar s = x * x;
  const Scalar p = (((((((1.55599142e-08f * s) + 2.20985712e-05f) * s) + 0.00358292833f) * s) + 0.134537607f) * s) + 1.0f;
  const Scalar q = (((((((8.646428e-07f * s) + 0.000343050633f) * s) + 0.0262066592f) * s) + 0.467870831f) * s) + 1.0f;
  return x * p / q;
}

static void tanh_layer(int inputs, int outputs, const IN_FLASH Scalar* weights, const IN_FLASH Scalar* bias,
                       const Scalar* in, Scalar* out) {
  dense(inputs, outputs, weights, bias, in, out);
  for (int o = 0; o < outputs; ++o) { out[o] = tanh_rational(out[o]); }
}

// z+ = z + (A - I) z + B0 y_k + B1 y_{k+1}; between samples y is a ramp
typedef struct {
  Scalar a_minus_1[kNz], b0[kNz][kNy], b1[kNz][kNy];
} Step;

static const IN_FLASH Step kStep = {  // over one sample period
    {-0.019801326f, -0.07688365f},
    {{0.009867662f}, {0.009482331f}},
    {{0.009933665f}, {0.009738582f}}};

// D [1/s], F and the steady state S y of a constant y.
static const IN_FLASH Scalar kEigenvalues[kNz] = {-1.0f, -4.0f};
static const IN_FLASH Scalar kOutputInjection[kNz][kNy] = {{1.0f}, {1.0f}};
static const IN_FLASH Scalar kSteadyGain[kNz][kNy] = {{1.0f}, {0.25f}};

// Computes the coefficients of a step over h seconds from phi at w = lambda h.
static void make_step(Scalar h, Step* step) {
  for (int r = 0; r < kNz; ++r) {
    Scalar phi1, phi2;
    phi(kEigenvalues[r] * h, &step->a_minus_1[r], &phi1, &phi2);
    for (int j = 0; j < kNy; ++j) {
      step->b0[r][j] = (phi1 - phi2) * h * kOutputInjection[r][j];
      step->b1[r][j] = phi2 * h * kOutputInjection[r][j];
    }
  }
}

// Advances z by one step.
static void advance(const Step* step, Scalar* z, const Scalar* y, const Scalar* y_next) {
  const Scalar* a = step->a_minus_1;
  Scalar change[kNz];
  for (int r = 0; r < kNz; ++r) { change[r] = a[r] * z[r]; }
  for (int r = 0; r < kNz; ++r) {
    for (int j = 0; j < kNy; ++j) { change[r] += (step->b0[r][j] * y[j]) + (step->b1[r][j] * y_next[j]); }
    z[r] += change[r];
  }
}

// z <- z + S y.
static void settle(tiny_c99_observer* o) {
  for (int r = 0; r < kNz; ++r) {
    for (int j = 0; j < kNy; ++j) { o->z[r] += kSteadyGain[r][j] * o->y[j]; }
  }
}

static void start(tiny_c99_observer* o, const Scalar* y) {
  copy(o->y, y, kNy);
  o->started = 1U;
}

// Resets an observer whose state a bit flip has corrupted. The next measurement is its first.
static tiny_c99_status reset_after_corruption(tiny_c99_observer* o) {
  tiny_c99_reset(o);
  return set_status(o, tiny_c99_RESET);
}

// Resets the observer if steps cannot lead to its state. Returns its status. A bit flip in a stored reading reaches z
// only after several steps, so stored readings that are reused are checked here.
static tiny_c99_status checked(tiny_c99_observer* o, bool held) {
  const bool good = held ? is_sound(o) : is_reachable(o->z);
  return good ? (tiny_c99_status)o->status : reset_after_corruption(o);
}

// Takes one step, over one sample period or another time.
static tiny_c99_status take(tiny_c99_observer* o, const Scalar* y, const Step* step) {
  Scalar next[kNy];
  copy(next, o->y, kNy);
  const bool held = validate(y, next, o->health);
  (void)update_status(o);
  if (o->started != 1U) {
    if (!is_sound(o)) { return reset_after_corruption(o); }
    if (held) { return (tiny_c99_status)o->status; }  // no good value to hold yet
    start(o, next);
    return checked(o, false);
  }
  advance(step, o->z, o->y, next);
  // With zero input z would stay subnormal for ever, and subnormals are slow on some cores.
  for (int r = 0; r < kNz; ++r) { o->z[r] = ((o->z[r] < kTiny) && (o->z[r] > -kTiny)) ? 0.0f : o->z[r]; }
  copy(o->y, next, kNy);
  return checked(o, held);
}

void tiny_c99_reset(tiny_c99_observer* observer) {
  load(observer->z, kInitial, kNz);
  load(observer->y, kNoOutput, kNy);
  for (int j = 0; j < kNy; ++j) { ((EACH_STORE uint16_t*)observer->health)[j] = 0U; }
  observer->status = (uint8_t)tiny_c99_OK;
  observer->started = 0U;
}

void tiny_c99_init(tiny_c99_observer* observer) { tiny_c99_reset(observer); }

tiny_c99_status tiny_c99_warm_start(tiny_c99_observer* observer, const float y[1]) {
  Scalar accepted[kNy];
  load(accepted, kNoOutput, kNy);
  const bool held = validate(y, accepted, observer->health);
  (void)update_status(observer);
  if (held) { return checked(observer, true); }
  load(observer->z, kInitial, kNz);
  start(observer, accepted);
  settle(observer);
  return (tiny_c99_status)observer->status;
}

tiny_c99_status tiny_c99_step(tiny_c99_observer* observer, const float y[1]) {
  return take(observer, y, REGULAR_STEP);
}

tiny_c99_status tiny_c99_step_dt(tiny_c99_observer* observer, const float y[1], float dt_s) {
  if (!(is_finite(dt_s) && (dt_s > 0.0f) && (dt_s <= ((Scalar)kLongestGap * kSamplePeriod)))) {
    return set_status(observer, tiny_c99_REJECTED);
  }
  Step step;
  make_step(dt_s, &step);
  // Up to 1.5 sample periods are jitter.
  const Scalar periods = dt_s / kSamplePeriod;
  if ((observer->started != 1U) || !((periods == periods) && (periods > 1.5f))) { return take(observer, y, &step); }
  const int missed = (int)(periods + 0.5f) - 1;
  uint16_t before[kNy];
  for (int j = 0; j < kNy; ++j) {
    before[j] = counted_on(observer->health[j], (uint16_t)missed, 1U);
    observer->health[j] = before[j];
  }
  const tiny_c99_status status = take(observer, y, &step);
  if (status == tiny_c99_RESET) { return status; }
  for (int j = 0; j < kNy; ++j) {
    const uint16_t now = observer->health[j];
    observer->health[j] = (now == 0U) ? (uint16_t)(before[j] - (before[j] % 4U)) : (uint16_t)(now | 1U);
  }
  return (status <= tiny_c99_OUT_OF_RANGE) ? update_status(observer) : status;
}

tiny_c99_status tiny_c99_step_missed(tiny_c99_observer* observer) {
  Scalar y[kNy];
  for (int j = 0; j < kNy; ++j) { y[j] = of_bits(0x7f800000U); }  // not finite
  return take(observer, y, REGULAR_STEP);
}

tiny_c99_status tiny_c99_last_status(const tiny_c99_observer* observer) {
  return is_sound(observer) ? (tiny_c99_status)observer->status : tiny_c99_RESET;
}

tiny_c99_status tiny_c99_status_of(const tiny_c99_observer* observer, int channel) {
  const tiny_c99_status all = tiny_c99_last_status(observer);
  if ((all == tiny_c99_REJECTED) || (all == tiny_c99_RESET)) { return all; }
  return ((channel < 0) || (channel >= 1)) ? tiny_c99_REJECTED : status_of_health(observer->health[channel]);
}

bool tiny_c99_in_domain(const tiny_c99_observer* observer) {
  bool inside = true;
  for (int j = 0; j < kNy; ++j) { inside = inside && !is_clamped(observer->health[j]); }
  for (int r = 0; r < kNz; ++r) {
    const Scalar relative = observer->z[r];
    inside = inside && (relative >= kLatentMin[r]) && (relative <= kLatentMax[r]);
  }
  return inside;
}

bool tiny_c99_restore(tiny_c99_observer* observer, const tiny_c99_observer* saved) {
  if (!is_sound(saved)) { return false; }
  copy(observer->z, saved->z, kNz);
  copy(observer->y, saved->y, kNy);
  for (int j = 0; j < kNy; ++j) { ((EACH_STORE uint16_t*)observer->health)[j] = saved->health[j]; }
  observer->status = saved->status;
  observer->started = saved->started;
  return true;
}

// Weights of T*, one neuron per line.
static const IN_FLASH Scalar kWeights1[4 * 2] = {
    0.232917f, 3.440228f,
    1.6481663f, -0.7788087f,
    -0.19503292f, 3.679755f,
    1.3204453f, 0.32287326f,
};
static const IN_FLASH Scalar kBias1[4] = {-0.5352224f, 0.5366941f, -0.48333663f, 0.20517758f};
static const IN_FLASH Scalar kWeights2[4] = {
    -0.14829469f, 0.09898687f, -0.21073124f, -1.0957534f,
};
static const IN_FLASH Scalar kBias2[1] = {0.5261358f};

void tiny_c99_estimate(const tiny_c99_observer* observer, float x_hat[1]) {
  const Scalar* in = observer->z;
  Scalar ping[4];
  tanh_layer(2, 4, kWeights1, kBias1, in, ping);
  dense(4, 1, kWeights2, kBias2, ping, x_hat);
}
