// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/of_use.hpp"

#include <algorithm>

#include "explain/model/between_rows.hpp"
#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

constexpr double kByPedal = 20.0;  // practical sizes, where the pedal is all that tells the torque: a tenth of it

/// Then how an inverter follows it, and what limits it, are in the balances of the car: errors of the model's as well.
bool torque_is_by_pedal(const Observed& log) {
  return log.comparison.log.find("motor_torque") == nullptr;
}

/// Rows so far apart that frames which were held are of other times.
bool is_seldom(const Observed& log) {
  constexpr double kSeldom_s = 0.15;  // chosen
  const VectorXd& time_s = log.comparison.log.time_s;
  return time_s(time_s.size() - 1) - time_s(0) > kSeldom_s * static_cast<double>(time_s.size());
}

/// Nobody read the motor's speed, and wheels may have spun since the row before.
bool spins_unseen(const Observed& log) {
  return log.comparison.log.derived.contains("motor_speed") && is_seldom(log);
}

}  // namespace

bool is_known_by_sound(const Observed& log, plant::Balance balance) {
  if (balance == plant::Balance::kPower) return torque_is_by_pedal(log) || spins_unseen(log);
  return balance == plant::Balance::kForce;
}

std::vector<double> asked_alone(const Observed& log) {
  constexpr double kFinest_k = 0.1, kCoarseAir = 3.0;
  // A load that is switched between rows far apart seems longer than it is, and a sound pack to have less polarization:
  // 1.2 and 1.5 times what half of the rows tell, at 0.25 and 1 s, in two drawn sound cars. Chosen on these.
  constexpr double kSwitched = 2.0;
  // Where nothing counts the charge either, a sound drawn car of 124 cells at 10 Hz missed 2.8 % of it: 1.0. Chosen.
  constexpr double kUncounted = 1.5;
  const bool in_laboratory = is_of_laboratory(log.comparison.log);
  const double of_rows = is_seldom(log) && !in_laboratory ? kSwitched : 1.0;
  const double of_charge = log.comparison.facts.counted_a.size() == 0 && !in_laboratory ? kUncounted : 1.0;
  const VectorXd* air = log.comparison.log.find("ambient");
  const bool air_is_coarse = air != nullptr && is_coarse(*air);
  std::vector<double> out;
  for (const ReadChannel& channel : log.channels) {
    const bool guessed = torque_is_by_pedal(log) || (channel.balance == plant::Balance::kPower && spins_unseen(log));
    double asked = !is_known_by_sound(log, channel.balance) ? 1.0 : guessed ? kByPedal : kAlone;
    const bool of_voltage = channel.balance == plant::Balance::kVoltage;
    asked = std::max(asked, (of_voltage ? std::max(of_rows, of_charge) : of_rows) * channel.between_rows);
    if (channel.balance == plant::Balance::kPower && is_seldom(log)) asked = std::max(asked, kAlone);
    if (channel.balance == plant::Balance::kHeat) {
      if (channel.practical > kFinest_k || !log.read.passed_s.empty()) asked = std::max(asked, kAlone);
      if (air_is_coarse) asked = std::max(asked, kCoarseAir);
    }
    out.push_back(asked);
  }
  return out;
}

std::vector<double> asked_between_rows(const Observed& log) {
  std::vector<double> out;
  for (const ReadChannel& channel : log.channels) out.push_back(std::max(1.0, channel.between_rows));
  return *std::max_element(out.begin(), out.end()) > 1.0 ? out : std::vector<double>();
}

}  // namespace voltlap::explain
