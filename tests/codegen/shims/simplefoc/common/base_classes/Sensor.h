// SPDX-License-Identifier: MIT
// The base class of SimpleFOC's sensors (2.2 to 2.3): the interface with its signatures and its documented behaviour.
#pragma once

#include <math.h>
#include <stdint.h>

#include <common/time_utils.h>

#define _2PI 6.28318530718f

class Sensor {
 public:
  virtual float getMechanicalAngle() { return angle_prev; }
  virtual float getAngle() { return static_cast<float>(full_rotations) * _2PI + angle_prev; }
  virtual double getPreciseAngle() {
    return static_cast<double>(full_rotations) * static_cast<double>(_2PI) + static_cast<double>(angle_prev);
  }
  // Returns the difference of angles between two calls, divided by the time between their updates.
  virtual float getVelocity() {
    const float seconds = static_cast<float>(static_cast<int32_t>(angle_prev_ts - vel_angle_prev_ts)) * 1e-6f;
    if (!(seconds < min_elapsed_time)) {
      velocity =
          (static_cast<float>(full_rotations - vel_full_rotations) * _2PI + angle_prev - vel_angle_prev) / seconds;
    }
    if (seconds < 0 || !(seconds < min_elapsed_time)) {
      vel_angle_prev = angle_prev;
      vel_angle_prev_ts = angle_prev_ts;
      vel_full_rotations = full_rotations;
    }
    return velocity;
  }
  virtual int32_t getFullRotations() { return full_rotations; }
  virtual void update() {
    const float angle = getSensorAngle();
    if (angle < 0) return;  // reported by the hardware as an error
    angle_prev_ts = static_cast<long>(_micros());
    const float change = angle - angle_prev;
    if (fabsf(change) > 0.8f * _2PI) full_rotations += change > 0 ? -1 : 1;
    angle_prev = angle;
  }
  virtual int needsSearch() { return 0; }

  float min_elapsed_time = 0.000100f;

 protected:
  virtual float getSensorAngle() = 0;
  virtual void init() {
    vel_angle_prev = angle_prev = getSensorAngle();
    vel_angle_prev_ts = angle_prev_ts = static_cast<long>(_micros());
  }

  float velocity = 0.0f;
  float angle_prev = 0.0f;
  long angle_prev_ts = 0;
  float vel_angle_prev = 0.0f;
  long vel_angle_prev_ts = 0;
  int32_t full_rotations = 0;
  int32_t vel_full_rotations = 0;
};
