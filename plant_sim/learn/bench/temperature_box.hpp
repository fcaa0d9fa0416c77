// SPDX-License-Identifier: Apache-2.0
// The box around the cells: which air the plant's thermal model of a cell (car/battery/pack.hpp) sees.
//
//   bath        the cells stay at the test's temperature: T_air = T_set with a surface that lets all heat through
//   controlled  heater and fan: T_air = T_set + gain (T_set - T_thermistors), within the air's limits
//   free        an insulated box that the cells warm themselves, air without heat capacity:
//               T_air = (hA sum T_cell + UA T_room) / (N hA + UA)
// Source: reference study, 2016, sections 5.5 and 7.5 (air inside the box taken as ambient).
#pragma once
#include <algorithm>
#include <vector>

#include "learn/bench/plan.hpp"

namespace voltlap::plant {

class TemperatureBox {
 public:
  TemperatureBox(const BoxSection& section, double set_c) : section_(section), set_c_(set_c), air_c_(set_c) {}

  /// Convection of a cell's surface in this box, of a cell file that says `own`.
  [[nodiscard]] double convection_w_per_m2_k(double own) const {
    constexpr double kBath = 1e9;
    return section_.mode == "bath"         ? kBath
           : section_.mode == "controlled" ? section_.fan_convection_w_per_m2_k
                                           : own;
  }
  void control(const std::vector<double>& thermistors_c) {
    if (section_.mode != "controlled") return;
    const double deviation = set_c_ - mean(thermistors_c);
    air_c_ = std::clamp(set_c_ + section_.gain * deviation, section_.air_min_c, section_.air_max_c);
  }
  /// `cooling_w_per_k`: hA of all cells together.
  void follow(const std::vector<double>& cells_c, double cooling_w_per_k) {
    if (section_.mode != "free") return;
    air_c_ = (cooling_w_per_k * mean(cells_c) + section_.loss_w_per_k * section_.room_c) /
             (cooling_w_per_k + section_.loss_w_per_k);
  }
  /// Whether the next pulse may begin.
  [[nodiscard]] bool ready(const std::vector<double>& thermistors_c) const {
    if (section_.mode != "controlled") return true;
    return std::all_of(thermistors_c.begin(), thermistors_c.end(),
                       [this](double t) { return t >= set_c_ - section_.band_k && t <= set_c_ + section_.band_k; });
  }
  [[nodiscard]] double air_c() const { return air_c_; }

 private:
  static double mean(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }

  BoxSection section_;
  double set_c_, air_c_;
};

}  // namespace voltlap::plant
