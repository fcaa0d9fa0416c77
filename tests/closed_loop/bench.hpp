// SPDX-License-Identifier: Apache-2.0
// Car, bus and firmware in lockstep under a given pedal, without a driver and without anybody who ends the run.
#pragma once
#include <vector>

#include "car/car.hpp"
#include "io/bus/in_process_loop.hpp"
#include "loop.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/sensors/sensor_frames.hpp"

namespace voltlap::plant::test {

class LoopBench {
 public:
  /// `representative`: one cell stands for all.
  explicit LoopBench(const VehicleParameters& parameters, bool representative = true, std::uint64_t seed = 1)
      : car(parameters, representative, 0.001), loop(parameters), frames_(car.parameters(), seed) {}

  void tick();
  void run_for(double seconds);
  /// Power-on to ready to drive, then full pedal for `seconds`.
  void drive_off(double seconds);
  [[nodiscard]] std::uint32_t now_ms() const { return tick_ * can::kTickMs; }
  [[nodiscard]] bool any_air_closed() const {
    return car.contactors.air_plus.closed() || car.contactors.air_minus.closed();
  }

  [[nodiscard]] SensorFaults& faults() { return frames_.faults; }

  Car car;
  SilenceableLoop loop;
  CommandReceiver commands;
  Pedals pedals;
  Switches switches;

 private:
  SensorFrames frames_;
  InProcessLoop bus_{loop};
  TxQueue tx_;
  std::vector<Frame> heard_;  // by the car, when the bus loses frames
  std::uint32_t tick_ = 0;
};

}  // namespace voltlap::plant::test
