// SPDX-License-Identifier: Apache-2.0
// Where the battery's energy went. Every term is integrated from its own force, current or heat flow; none is the
// remainder of the others, so the sum tells whether the model conserves energy.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace voltlap::plant {

inline constexpr double kJoulesPerKwh = 3.6e6;

enum class EnergyTerm : std::size_t {
  kBatteryChemical,  ///< the one source: current times open-circuit voltage
  kBatteryR0Heat, kBatteryRcHeat, kBatteryRcStored,
  kContactorHeat, kBleedHeat, kDcLinkStored, kLowVoltage,
  kInverterHeat, kMotorHeat, kDrivelineHeat,
  kKinetic, kClimb, kAero, kRolling, kCornering, kTyreSlip, kBrakeFront, kBrakeRear,
  kCount
};
inline constexpr std::size_t kEnergyTerms = static_cast<std::size_t>(EnergyTerm::kCount);

[[nodiscard]] constexpr const char* energy_term_name(EnergyTerm term) {
  constexpr const char* kNames[kEnergyTerms] = {
      "battery_chemical", "battery_r0_heat", "battery_rc_heat", "battery_rc_stored", "contactor_heat", "bleed_heat",
      "dc_link_stored", "low_voltage", "inverter_heat", "motor_heat", "driveline_heat", "kinetic", "climb", "aero",
      "rolling", "cornering", "tyre_slip", "brake_front", "brake_rear"};
  return kNames[static_cast<std::size_t>(term)];
}

class EnergyLedger {
 public:
  void add(EnergyTerm term, double joules) { terms_[static_cast<std::size_t>(term)] += joules; }
  [[nodiscard]] double operator[](EnergyTerm term) const { return terms_[static_cast<std::size_t>(term)]; }

  /// Source minus all the rest [J]; 0 when energy is conserved.
  [[nodiscard]] double residual_j() const {
    double sum = terms_[0];
    for (std::size_t i = 1; i < kEnergyTerms; ++i) sum -= terms_[i];
    return sum;
  }
  /// |residual| over the source's energy, in percent.
  [[nodiscard]] double error_pct() const { return terms_[0] != 0.0 ? 100.0 * std::abs(residual_j() / terms_[0]) : 0.0; }

  /// What happened since `earlier`, for a lap's own balance.
  [[nodiscard]] EnergyLedger since(const EnergyLedger& earlier) const {
    EnergyLedger out = *this;
    for (std::size_t i = 0; i < kEnergyTerms; ++i) out.terms_[i] -= earlier.terms_[i];
    return out;
  }

 private:
  std::array<double, kEnergyTerms> terms_{};
};

}  // namespace voltlap::plant
