// SPDX-License-Identifier: MIT
// The part of Simulink's S-function interface that an exported block uses: the engine's side of a block, in plain
// memory.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

typedef double real_T;
typedef int int_T;
typedef int32_t int32_T;
typedef unsigned char boolean_T;
typedef unsigned int uint_T;

enum { SS_DOUBLE, SS_INT32 = 6, SS_BOOLEAN = 8 };
enum { SS_OPTION_EXCEPTION_FREE_CODE = 1, SS_OPTION_DISALLOW_CONSTANT_SAMPLE_TIME = 2 };
enum { USE_DEFAULT_OPERATING_POINT = 1 };
enum { kShimPorts = 4 };

typedef struct {
  int width, type, feedthrough, contiguous;
  double* signal;  // signals of any type
} ShimPort;

typedef struct {
  int parameters, given_parameters, continuous, discrete, inputs, outputs, works, sample_times, options, compliance;
  ShimPort input[kShimPorts], output[kShimPorts], work[kShimPorts];
  double sample_time, offset;
} SimStruct;

static inline bool shim_ports(int* count, ShimPort* ports, int wanted) {
  *count = wanted;
  for (int p = 0; p < wanted; ++p) ports[p] = (ShimPort){.width = 0, .type = SS_DOUBLE};
  return wanted <= kShimPorts;
}

#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) ((S)->given_parameters)
#define ssSetNumContStates(S, n) ((S)->continuous = (n))
#define ssSetNumDiscStates(S, n) ((S)->discrete = (n))
#define ssSetNumInputPorts(S, n) shim_ports(&(S)->inputs, (S)->input, n)
#define ssSetNumOutputPorts(S, n) shim_ports(&(S)->outputs, (S)->output, n)
#define ssSetInputPortWidth(S, p, n) ((S)->input[p].width = (n))
#define ssSetInputPortRequiredContiguous(S, p, n) ((S)->input[p].contiguous = (n))
#define ssSetInputPortDirectFeedThrough(S, p, n) ((S)->input[p].feedthrough = (n))
#define ssSetOutputPortWidth(S, p, n) ((S)->output[p].width = (n))
#define ssSetOutputPortDataType(S, p, t) ((S)->output[p].type = (t))
#define ssSetNumSampleTimes(S, n) ((S)->sample_times = (n))
#define ssSetNumDWork(S, n) shim_ports(&(S)->works, (S)->work, n)
#define ssSetDWorkWidth(S, p, n) ((S)->work[p].width = (n))
#define ssSetDWorkDataType(S, p, t) ((S)->work[p].type = (t))
#define ssSetOperatingPointCompliance(S, c) ((S)->compliance = (c))
#define ssSetOptions(S, o) ((S)->options = (o))
#define ssSetSampleTime(S, i, t) ((void)(i), (S)->sample_time = (t))
#define ssSetOffsetTime(S, i, t) ((void)(i), (S)->offset = (t))
#define ssSetModelReferenceSampleTimeDefaultInheritance(S) ((void)(S))
#define ssGetInputPortRealSignal(S, p) ((const real_T*)(S)->input[p].signal)
#define ssGetOutputPortRealSignal(S, p) ((real_T*)(S)->output[p].signal)
#define ssGetOutputPortSignal(S, p) ((void*)(S)->output[p].signal)
#define ssGetDWork(S, p) ((void*)(S)->work[p].signal)
#define UNUSED_ARG(a) ((void)(a))
