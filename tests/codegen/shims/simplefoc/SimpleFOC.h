// SPDX-License-Identifier: MIT
// A minimal SimpleFOC for exported sketches: a motor that follows its voltage, an encoder on its shaft, and a loop with
// a period of a fifth of a millisecond.
#pragma once

#include <Arduino.h>
#include <common/base_classes/Sensor.h>

inline unsigned long _micros() {
  return micros();
}

struct SimulatedShaft {
  float angle = 0, speed = 0;
};
inline SimulatedShaft& simulated_shaft() {
  static SimulatedShaft shaft;
  return shaft;
}

struct MagneticSensorI2CConfig_s {
  int bit_resolution;
};
static const MagneticSensorI2CConfig_s AS5600_I2C = {12};

class MagneticSensorI2C : public Sensor {
 public:
  explicit MagneticSensorI2C(MagneticSensorI2CConfig_s config)
      : counts_(static_cast<float>(1L << config.bit_resolution)) {}
  void init() override { Sensor::init(); }
  float getSensorAngle() override {
    const float turns = simulated_shaft().angle / _2PI;
    return floorf((turns - floorf(turns)) * counts_) / counts_ * _2PI;
  }

 private:
  float counts_;
};

struct BLDCDriver3PWM {
  BLDCDriver3PWM(int, int, int, int) {}
  int init() { return 1; }
  float voltage_power_supply = 0;
};

enum Direction : int8_t { CW = 1, CCW = -1, UNKNOWN = 0 };
enum MotionControlType : uint8_t { torque = 0, velocity = 1, angle = 2 };
struct DQ_s {
  float d, q;
};
struct LowPassFilter {
  float Tf;
};

class BLDCMotor {
 public:
  explicit BLDCMotor(int) {}
  void linkSensor(Sensor* given) { sensor = given; }
  void linkDriver(BLDCDriver3PWM*) {}
  int init() { return 1; }
  int initFOC() {
    sensor_direction = CW;
    return sensor->needsSearch() == 0;
  }
  void loopFOC() { sensor->update(); }
  void move(float target) {
    simulated_shaft().speed += 0.01f * (target - simulated_shaft().speed);
    simulated_shaft().angle += simulated_shaft().speed * 2e-4f;
    voltage.q = 0.1f * (target - sensor->getVelocity());
  }
  Sensor* sensor = nullptr;
  MotionControlType controller = torque;
  Direction sensor_direction = UNKNOWN;
  DQ_s voltage = {0, 0}, current = {0, 0};
  LowPassFilter LPF_velocity = {0.005f};
};
