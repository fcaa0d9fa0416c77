// SPDX-License-Identifier: Apache-2.0
// What must hold while the car drives its laps (keys assertions.* of a vehicle); a run that breaks it has failed.
#pragma once
#include <optional>
#include <string>

#include "car/car.hpp"
#include "core/parameters.hpp"
#include "race/actuators/command_receiver.hpp"

namespace voltlap::plant {

/// The driver's moment: since the drive began, and since the target speed last began anew; where on which lap, from 1.
struct DriveMoment {
  double time_s, since_seam_s, target_mps;
  int lap = 1;
  double lap_distance_m = 0.0;
  double offset_m = 0.0;  ///< beside the line of the course
};

class RunAssertions {
 public:
  /// `by_position`: the driver follows the road, so that a car that stands still never arrives.
  RunAssertions(const AssertionSection& bounds, bool by_position) : bounds_(bounds), by_position_(by_position) {}

  /// The first assertion that does not hold, in words; nothing when all do. Once a tick, in the order of time.
  [[nodiscard]] std::optional<std::string> broken(const Car& car, const CommandReceiver& ecus, const DriveMoment& now);

 private:
  [[nodiscard]] bool stalled(double distance_m, double time_s);

  const AssertionSection& bounds_;
  bool by_position_;
  double progress_m_ = 0.0, progress_s_ = 0.0;  ///< last metre that was made, and when
};

/// What the ECUs last said of themselves, for messages.
[[nodiscard]] std::string state_text(const Car& car, const CommandReceiver& ecus);

}  // namespace voltlap::plant
