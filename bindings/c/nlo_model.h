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
 * Errors   If a call fails, a function that makes an object returns NULL, and any other function returns a negative
 *          nlo_result; nlo_last_error() returns the text. No function throws. Pointers must be NULL or valid.
 * Numbers  Numbers are double in this interface, in both precisions. Arrays have one sample after the other:
 *          y[k * n_y + j].
 * Threads  A model never changes: any number of threads may use it and make observers of it. Only one thread at a time
 *          may use an observer. Each thread has its own text of the last error. You may free models and observers in any
 *          order: an observer keeps the parts of its model that it needs.
 * Memory   nlo_observer_create() allocates the memory for all steps. The functions that a loop calls, from step to reset,
 *          allocate nothing and take no lock. (If the library was opened by dlopen(), the first call of a thread may
 *          allocate.) The time of a step has no proven bound; the steps of an export have one.
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

/* Number of the binary interface, also in the name libnlo-model.so.2. With the same number, functions and constants may be
 * added but not changed. A program that was built with this header runs if nlo_abi_version() returns this number. */
#define NLO_MODEL_ABI 2

typedef struct nlo_model nlo_model;
typedef struct nlo_observer nlo_observer;

enum nlo_result {
  NLO_DONE = 0,
  NLO_BAD_ARGUMENT = -1, /* a pointer is NULL, or a number outside of its range */
  NLO_BAD_MODEL = -2,    /* the file cannot be read, or is not a valid model */
  NLO_NO_MEMORY = -3,
  NLO_NOT_KNOWN = -4, /* the model does not have the requested part */
  NLO_FAILED = -5     /* anything else */
};

/* The status of a step: how it used its measurement. The latent state is finite after every step. */
enum nlo_status {
  NLO_OK = 0,           /* the measurement was used unchanged */
  NLO_CLAMPED = 1,      /* an output or input outside its declared range was clamped to it */
  NLO_HELD = 2,         /* an output was missing, not finite, or an angle out of range: its last good value was used */
  NLO_STALE = 3,        /* an output or input was held for about a time constant: do not trust the estimates */
  NLO_OUT_OF_RANGE = 4, /* an output or input was out of range for about a time constant: do not trust the estimates */
  NLO_REJECTED = 5,     /* the time step was not positive, or longer than the model can span: nothing changed */
  NLO_DIVERGED = 6,     /* the step would have overflowed: the last z was kept */
  NLO_RESET = 7         /* a bit flip corrupted the state; only exported observers return this */
};

enum nlo_precision { NLO_FLOAT = 32, NLO_DOUBLE = 64 }; /* of the arithmetic; `nlo evaluate` judges float */
enum nlo_channel { NLO_OUTPUT = 0, NLO_INPUT = 1, NLO_STATE = 2 };

NLO_API int nlo_abi_version(void);               /* NLO_MODEL_ABI of the library */
NLO_API const char* nlo_version(void);           /* version of nlo, "0.2.0" */
NLO_API const char* nlo_last_error(void);        /* of this thread: "FILE: FIELD: what is wrong"; "": no error yet */
NLO_API const char* nlo_status_text(int status); /* "ok", "clamped", ... */

/* Reads a model from bytes in memory, or from a file, and checks every field. Returns NULL if it is not valid. */
NLO_API nlo_model* nlo_model_from_bytes(const void* bytes, size_t size);
NLO_API nlo_model* nlo_model_from_file(const char* path);
NLO_API void nlo_model_free(nlo_model* model); /* NULL is fine */

/* Sizes and facts. If `model` is NULL they return 0 or "". Texts live as long as the model. */
NLO_API const char* nlo_model_name(const nlo_model* model);
NLO_API const char* nlo_model_structure(const nlo_model* model); /* "kkl", "gated", ... */
NLO_API double nlo_model_sample_period_s(const nlo_model* model);
NLO_API int nlo_model_ny(const nlo_model* model);        /* outputs that a step takes */
NLO_API int nlo_model_nu(const nlo_model* model);        /* known inputs that a step takes; 0: none */
NLO_API int nlo_model_nx(const nlo_model* model);        /* estimated states */
NLO_API int nlo_model_nz(const nlo_model* model);        /* latent states */
NLO_API int nlo_model_nr(const nlo_model* model);        /* readings: outputs (also computed), inputs, stalenesses */
NLO_API int nlo_model_has_sigma(const nlo_model* model); /* 1: it estimates the standard deviations of its errors */

/* Facts about one channel: its name, its unit ("": not known), the full turn of an angle (0: not an angle), and its
 * declared range (infinite: not declared). A measurement outside of its range is clamped, but not an angle, and not an
 * output that T* reads only relative to z. */
NLO_API const char* nlo_model_channel_name(const nlo_model* model, int channel, int index);
NLO_API const char* nlo_model_channel_unit(const nlo_model* model, int channel, int index);
NLO_API double nlo_model_channel_turn(const nlo_model* model, int channel, int index);
NLO_API int nlo_model_channel_range(const nlo_model* model, int channel, int index, double* low, double* high);

/* Returns the model file in the format of this version, with a 0 at its end. The text lives as long as the model. */
NLO_API const char* nlo_model_json(const nlo_model* model);

/* Writes D (n_z x n_z) and F (n_z x n_r) of dz/dt = D z + F y, row after row. NLO_NOT_KNOWN: z does not follow such an
 * equation. */
NLO_API int nlo_model_linear_latent(const nlo_model* model, double* d, double* f);

/* Computes x_hat = T*(z, readings) for `count` samples. readings may be NULL if T* reads only z. */
NLO_API int nlo_model_inverse_map(const nlo_model* model, int precision, size_t count, const double* z,
                                  const double* readings, double* x_hat);

/* Runs a new observer over `samples` samples. The results are those of single steps, except for rounding, because the
 * estimates are computed as products of matrices.
 * time_s   `samples` time stamps, or NULL: each step is one sample period
 * u        NULL if the model has no inputs
 * x_hat, sigma (n_x each), z (n_z), status, in_domain: arrays for `samples` results; NULL: not needed */
NLO_API int nlo_model_run(const nlo_model* model, int precision, size_t samples, const double* y, const double* u,
                          const double* time_s, double* x_hat, double* sigma, double* z, int32_t* status,
                          uint8_t* in_domain);

/* Makes an observer before its first sample. Returns NULL if there is not enough memory or no such precision. */
NLO_API nlo_observer* nlo_observer_create(const nlo_model* model, int precision);
NLO_API nlo_observer* nlo_observer_copy(const nlo_observer* observer);
NLO_API void nlo_observer_free(nlo_observer* observer); /* NULL is fine */
NLO_API int nlo_observer_reset(nlo_observer* observer);

/* Steps by one sample with the outputs y (angles as the sensor gives them, NaN: missing) and the inputs u. Returns an
 * nlo_status, or a negative nlo_result. */
NLO_API int nlo_observer_step(nlo_observer* observer, const double* y, const double* u); /* by one sample period */
NLO_API int nlo_observer_step_dt(nlo_observer* observer, const double* y, const double* u, double dt_s); /* by dt_s */

NLO_API int nlo_observer_status(const nlo_observer* observer);    /* of the last step */
NLO_API int nlo_observer_in_domain(const nlo_observer* observer); /* 1: z is in the training domain; 0: it is not */
NLO_API int nlo_observer_estimate(const nlo_observer* observer, double* x_hat);
/* sigma is 2^100 outside of the training domain, where the error is unknown. NLO_NOT_KNOWN: the model has no sigma. */
NLO_API int nlo_observer_estimate_with_error(const nlo_observer* observer, double* x_hat, double* sigma);
NLO_API int nlo_observer_latent(const nlo_observer* observer, double* z);

/* Saves the state of an observer as nlo_observer_state_size() numbers. After nlo_observer_restore() an observer of the
 * same model and precision continues with the same bits. Numbers that are not a saved state are refused. */
NLO_API int nlo_observer_state_size(const nlo_observer* observer);
NLO_API int nlo_observer_save(const nlo_observer* observer, double* state);
NLO_API int nlo_observer_restore(nlo_observer* observer, const double* state, size_t size);

#ifdef __cplusplus
}
#endif

#endif
