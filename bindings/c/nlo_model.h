/* SPDX-License-Identifier: MIT
 * One stable C interface to every observer that nlo trains, whatever its structure: libnlo-model loads model.json and
 * steps it. For control loops on a microcontroller, `nlo export` writes C++20 or C99 instead.
 *
 *   nlo_model *model = nlo_model_from_file("model.json");
 *   if (model == NULL) { fprintf(stderr, "%s\n", nlo_last_error()); return 1; }
 *   nlo_observer *observer = nlo_observer_create(model, NLO_FLOAT);
 *   nlo_observer_step(observer, y, u);              // y: nlo_model_ny(model) numbers; u: NULL where it has no input
 *   nlo_observer_estimate(observer, x_hat);         // nlo_model_nx(model) numbers
 *   nlo_observer_free(observer);
 *   nlo_model_free(model);
 *
 * Errors   A function that makes something returns NULL, others a negative nlo_result; nlo_last_error() has the text.
 *          Nothing is thrown, whatever is given; pointers must be NULL or valid.
 * Numbers  Are double here in both precisions. Arrays of samples have one sample after the other: y[k * n_y + j].
 * Threads  A model never changes: any number of threads may use it and make observers of it. An observer is for one
 *          thread at a time. The text of the last error belongs to its thread. Models and observers may be freed in any
 *          order; an observer keeps what it needs of its model.
 * Memory   An observer has the memory for its steps from nlo_observer_create() on: what is done with it in a loop, from
 *          step to reset, takes none from the system, and no lock. (The first call of a thread may take some, where the
 *          library was opened by dlopen().) How long a step takes has no bound that is proven, as that of an export has.
 */
#ifndef NLO_MODEL_H
#define NLO_MODEL_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define NLO_API
#else
#define NLO_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Number of the binary interface, also in the name libnlo-model.so.2. Functions and constants are added to it, not
 * changed; a program that was built with this header runs where nlo_abi_version() is the same. */
#define NLO_MODEL_ABI 2

typedef struct nlo_model nlo_model;
typedef struct nlo_observer nlo_observer;

enum nlo_result {
  NLO_DONE = 0,
  NLO_BAD_ARGUMENT = -1, /* a pointer is NULL, or a number outside of its range */
  NLO_BAD_MODEL = -2,    /* the file cannot be read, or is not a valid model */
  NLO_NO_MEMORY = -3,
  NLO_NOT_KNOWN = -4, /* the model does not have what is asked for */
  NLO_FAILED = -5     /* anything else */
};

/* What became of a measurement; the latent state is finite after each. */
enum nlo_status {
  NLO_OK = 0,           /* the measurement was used unchanged */
  NLO_CLAMPED = 1,      /* an output or input outside its declared range was clamped to it */
  NLO_HELD = 2,         /* an output was missing, not finite, or an angle out of range: its last good value was used */
  NLO_STALE = 3,        /* an output or input was held for about a time constant: do not trust the estimates */
  NLO_OUT_OF_RANGE = 4, /* an output or input was out of range for about a time constant: do not trust the estimates */
  NLO_REJECTED = 5,     /* the time step was not positive, or longer than the model can span: nothing was done */
  NLO_DIVERGED = 6,     /* the step would have overflowed: the last z was kept */
  NLO_RESET = 7         /* a bit flip corrupted the state: only exported observers say so */
};

enum nlo_precision { NLO_FLOAT = 32, NLO_DOUBLE = 64 }; /* of the arithmetic; float is what `nlo evaluate` measures */
enum nlo_channel { NLO_OUTPUT = 0, NLO_INPUT = 1, NLO_STATE = 2 };

NLO_API int nlo_abi_version(void);        /* NLO_MODEL_ABI of the library */
NLO_API const char* nlo_version(void);    /* "0.2.0", of nlo */
NLO_API const char* nlo_last_error(void); /* of this thread: "FILE: FIELD: what is wrong"; "" where there was none */
NLO_API const char* nlo_status_text(int status); /* "ok", "clamped", ... */

/* A model file as bytes in memory, or by its path. Every field is checked. NULL: it is not valid. */
NLO_API nlo_model* nlo_model_from_bytes(const void* bytes, size_t size);
NLO_API nlo_model* nlo_model_from_file(const char* path);
NLO_API void nlo_model_free(nlo_model* model); /* NULL is fine */

/* Sizes and facts. Of NULL: 0, or "". Texts live as long as the model. */
NLO_API const char* nlo_model_name(const nlo_model* model);
NLO_API const char* nlo_model_structure(const nlo_model* model); /* "kkl", "gated", ... */
NLO_API double nlo_model_sample_period_s(const nlo_model* model);
NLO_API int nlo_model_ny(const nlo_model* model); /* outputs that a step takes */
NLO_API int nlo_model_nu(const nlo_model* model); /* known inputs that a step takes; 0: none */
NLO_API int nlo_model_nx(const nlo_model* model); /* estimated states */
NLO_API int nlo_model_nz(const nlo_model* model); /* latent states */
NLO_API int nlo_model_nr(const nlo_model* model); /* readings: outputs, computed ones too, inputs read, stalenesses */
NLO_API int nlo_model_has_sigma(const nlo_model* model); /* 1: it knows the standard deviations of its errors */

/* Of one channel: name, unit ("" where none is known), the full turn of an angle (0: not an angle), and its declared
 * range, infinite where there is none. Outside it a measurement is clamped, but not an angle or an output that T* knows
 * only relatively. */
NLO_API const char* nlo_model_channel_name(const nlo_model* model, int channel, int index);
NLO_API const char* nlo_model_channel_unit(const nlo_model* model, int channel, int index);
NLO_API double nlo_model_channel_turn(const nlo_model* model, int channel, int index);
NLO_API int nlo_model_channel_range(const nlo_model* model, int channel, int index, double* low, double* high);

/* The model file as this version writes it, with a 0 at its end. Lives as long as the model. */
NLO_API const char* nlo_model_json(const nlo_model* model);

/* D (n_z x n_z) and F (n_z x n_r), row after row, of dz/dt = D z + F y. NLO_NOT_KNOWN where that is not how z runs. */
NLO_API int nlo_model_linear_latent(const nlo_model* model, double* d, double* f);

/* x_hat = T*(z, readings) of `count` columns; readings may be NULL where nothing but z is read. */
NLO_API int nlo_model_inverse_map(const nlo_model* model, int precision, size_t count, const double* z,
                                  const double* readings, double* x_hat);

/* A whole run from a reset, as steps one by one give it, but for rounding: its estimates are products of matrices.
 * time_s   `samples` time stamps, or NULL: each step is one sample period
 * u        NULL where the model has no inputs
 * x_hat, sigma (n_x each), z (n_z), status, in_domain: a place for `samples` of each, or NULL: not wanted */
NLO_API int nlo_model_run(const nlo_model* model, int precision, size_t samples, const double* y, const double* u,
                          const double* time_s, double* x_hat, double* sigma, double* z, int32_t* status,
                          uint8_t* in_domain);

/* An observer before its first sample. NULL: no memory, or no such precision. */
NLO_API nlo_observer* nlo_observer_create(const nlo_model* model, int precision);
NLO_API nlo_observer* nlo_observer_copy(const nlo_observer* observer);
NLO_API void nlo_observer_free(nlo_observer* observer); /* NULL is fine */
NLO_API int nlo_observer_reset(nlo_observer* observer);

/* One sample with the outputs y, angles as the sensor gives them, NaN where one is missing, and the inputs u. Returns an
 * nlo_status, or a negative nlo_result. */
NLO_API int nlo_observer_step(nlo_observer* observer, const double* y, const double* u); /* a sample period */
NLO_API int nlo_observer_step_dt(nlo_observer* observer, const double* y, const double* u, double dt_s); /* any other */

NLO_API int nlo_observer_status(const nlo_observer* observer);    /* of the last step */
NLO_API int nlo_observer_in_domain(const nlo_observer* observer); /* 1: z is where training has been; 0: it is not */
NLO_API int nlo_observer_estimate(const nlo_observer* observer, double* x_hat);
/* sigma is 2^100 outside of the training domain, where the error is unknown. NLO_NOT_KNOWN where the model has none. */
NLO_API int nlo_observer_estimate_with_error(const nlo_observer* observer, double* x_hat, double* sigma);
NLO_API int nlo_observer_latent(const nlo_observer* observer, double* z);

/* All that a step changes, as numbers to keep: nlo_observer_state_size() of them. After nlo_observer_restore() an
 * observer of the same model and precision goes on with the same bits. What is not a saved state is refused. */
NLO_API int nlo_observer_state_size(const nlo_observer* observer);
NLO_API int nlo_observer_save(const nlo_observer* observer, double* state);
NLO_API int nlo_observer_restore(nlo_observer* observer, const double* state, size_t size);

#ifdef __cplusplus
}
#endif

#endif
