// SPDX-License-Identifier: MIT
// The motor of examples/simplefoc in a loop of SimpleFOC: 20 runs of 4 s under voltage steps; friction and load are
// drawn for each run; the encoder has a given number of steps per turn. Prints the RMSE of the speed after .3 s [rad/s]
// for the exported sensor and for SimpleFOC without it, which filters differences of angles by a low-pass with its
// default time constant, and with the best of five.
#include <stdio.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <hall_motor_sensor.h>

namespace {

struct Motor {
  double theta = 0, omega = 0, current = 0, voltage = 0, friction = 0, load = 0;

  void run(double seconds) {
    constexpr double kR = 2, kL = 0.003, kK = 0.05, kJ = 0.0002;
    constexpr int kParts = 8;
    for (int part = 0; part < kParts; ++part) {
      const double h = seconds / kParts;
      current += h * (voltage - kR * current - kK * omega) / kL;
      omega += h * (kK * current - friction * omega - load) / kJ;
      theta += h * omega;
    }
  }
};

Motor motor;
double measured_current = 0;
unsigned long now_us = 0;

class Encoder : public Sensor {
 public:
  explicit Encoder(int steps) : steps_(steps) {}
  void init() override { Sensor::init(); }
  float getSensorAngle() override {
    const double turns = motor.theta / 6.283185307179586;
    return static_cast<float>(std::floor((turns - std::floor(turns)) * steps_) / steps_ * 6.283185307179586);
  }

 private:
  int steps_;
};

void readings(float* y, float* u) {
  y[hall_motor_output_current] = static_cast<float>(measured_current);
  u[hall_motor_input_voltage] = static_cast<float>(motor.voltage);
}

}  // namespace

unsigned long _micros() {
  return now_us;
}

int main() {
  constexpr double kFilters_s[] = {0.005, 0.0025, 0.01, 0.02, 0.04};  // the first is the default of SimpleFOC
  constexpr int kFilters = 5, kRuns = 20;
  constexpr unsigned long kLoop_us = 200, kEnd_us = 4000000, kSettled_us = 300000;
  for (const int steps : {42, 256, 2000, 4096}) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 0.02);
    std::uniform_real_distribution<double> part(0, 1);
    double of_sensor = 0, of_filter[kFilters] = {}, samples = 0;
    for (int run = 0; run < kRuns; ++run) {
      motor = Motor();
      motor.friction = 0.00002 + 0.00038 * part(random);
      motor.load = -0.02 + 0.04 * part(random);
      now_us = 0;
      Encoder encoder(steps);
      encoder.init();
      hall_motor_sensor sensor(encoder, readings);
      sensor.init();
      double filtered[kFilters] = {};
      unsigned long next_us = 0;
      while (now_us < kEnd_us) {
        if (now_us >= next_us) {
          motor.voltage = -12 + 24 * part(random);
          next_us = now_us + static_cast<unsigned long>(50000 + 800000 * part(random));
        }
        motor.run(kLoop_us * 1e-6);
        now_us += kLoop_us;
        measured_current = motor.current + noise(random);
        sensor.update();
        const double difference = static_cast<double>(sensor.Sensor::getVelocity());
        const bool settled = now_us > kSettled_us;
        const auto square = [&](double speed) { return settled ? std::pow(speed - motor.omega, 2) : 0.0; };
        of_sensor += square(static_cast<double>(sensor.getVelocity()));
        for (int i = 0; i < kFilters; ++i) {
          const double keep = kFilters_s[i] / (kFilters_s[i] + kLoop_us * 1e-6);
          filtered[i] = keep * filtered[i] + (1 - keep) * difference;
          of_filter[i] += square(filtered[i]);
        }
        samples += settled ? 1 : 0;
      }
    }
    const auto rmse = [&](double sum) { return std::sqrt(sum / samples); };
    printf("| %d | %.1f | %.1f | %.1f |\n", steps, rmse(of_sensor), rmse(of_filter[0]),
           rmse(*std::min_element(of_filter, of_filter + kFilters)));
  }
  return 0;
}
