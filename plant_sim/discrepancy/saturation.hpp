// SPDX-License-Identifier: Apache-2.0
// A current sensor that ends at a limit. Its readings pile up there, as those of a battery do that is held at a limit;
// but the voltage sags beyond what they give, and the rest of the log agrees with the current that it asks for.
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "discrepancy/design.hpp"
#include "discrepancy/explain.hpp"

namespace voltlap::plant {

/// The pile of readings at the end of a current.
struct Rail {
  double limit_a = 0.0, noise_a = 0.0;  ///< mean and standard deviation of its readings
  double from_a = 0.0;                  ///< no reading of the limit is less
  double step_a = 0.0;                  ///< of the log's readings; 0: they have none
  std::vector<bool> at;                 ///< rows that read it
};
[[nodiscard]] std::optional<Rail> rail_of(const Eigen::VectorXd& current_a);

struct Saturation {
  Rail rail;
  double most_a = 0.0;      ///< that is missing, by the voltage
  double before_v = 0.0, after_v = 0.0;  ///< RMS error of the voltage below: by the readings, by what flowed
  double share = 0.0;       ///< of the squares of all rows
  double d_prime = 0.0;     ///< of what no resistance, lag or OCV behind the readings can follow
};

/// The rail of the log, if the voltage says that more flowed there than was read.
[[nodiscard]] std::optional<Saturation> saturation_of(const World& model, const Comparison& comparison);

[[nodiscard]] FoundCause found_saturation(const Saturation& saturation);
void mask_rail(const Saturation& saturation, const Recording& log, std::vector<Masked>& masked);

/// Puts what it says in front of all else that was found.
void say_first(const std::string& says, std::string& sentence);

/// What was gained begins with the readings as they are.
void put_readings_before(const World& given, const Design& design, const Comparison& measured_on, Explanation& out);

}  // namespace voltlap::plant
