// SPDX-License-Identifier: Apache-2.0
// What the reference study, 2016, found for its own cells and recordings, to stand beside what is found here.
#pragma once
#include <array>
#include <optional>
#include <string_view>

namespace voltlap::plant::study {

/// RMS errors [V]; sections 7.1, 7.2 and 7.3.
inline constexpr double kRmsConstantCurrent = 0.015;
inline constexpr double kRmsVariableCurrent = 0.0328, kRmsVariableCurrentReduced = 0.0305,
                        kRmsVariableCurrentAdjusted = 0.0157, kVariableCurrentByAh = -0.72;
inline constexpr double kRmsVariableTemperature = 0.0646, kRmsVariableTemperatureReduced = 0.0601,
                        kRmsVariableTemperatureAdjusted = 0.0192, kVariableTemperatureByAh = 1.2;
/// Of its variable-current recording, without current in one parameter.
inline constexpr double kRmsWithoutCurrentInEm = 0.0309, kRmsWithoutCurrentInR0 = 0.0325;

/// Tables 7.1 and 7.2.
struct TableRow {
  std::string_view parameter;
  double pct_per_ampere, pct_per_kelvin;
};
inline constexpr std::array<TableRow, 6> kTableSensitivity{{{"em", -9.90e-4, -0.012},
                                                            {"r0", -0.034, -1.4},
                                                            {"r1", -0.21, -1.9},
                                                            {"r2", -0.0019, -1.4},
                                                            {"tau1", -0.23, -1.4},
                                                            {"tau2", -0.27, -1.2}}};

/// Table 7.3 [V]: +5 %, +1 %, nominal, -1 %, -5 %.
struct ErrorRow {
  std::string_view parameter;
  std::array<double, 5> rms_v;
};
inline constexpr std::array<ErrorRow, 8> kErrorSensitivity{
    {{"em", {0.1928, 0.0420, 0.0192, 0.0442, 0.1952}},
     {"r0", {0.0191, 0.0191, 0.0192, 0.0193, 0.0198}},
     {"r1", {0.0192, 0.0192, 0.0192, 0.0192, 0.0191}},
     {"r2", {0.0192, 0.0192, 0.0192, 0.0192, 0.0192}},
     {"c1", {0.0192, 0.0192, 0.0192, 0.0192, 0.0192}},
     {"c2", {0.0191, 0.0192, 0.0192, 0.0192, 0.0192}},
     {"initial_soc", {0.1012, 0.0281, 0.0192, 0.0349, 0.1351}},
     {"capacity", {0.0912, 0.0265, 0.0192, 0.0334, 0.1275}}}};

/// Table B.6.
inline constexpr double kHeatCapacity_j_per_kg_k = 747.0, kConvection_w_per_m2_k = 5.0;

/// Appendix C: 24 cells against one, of the pack's voltage.
inline constexpr double kPackMean_v = -2.7e-4, kPackSnr = 706.0, kPackSocMax = 1.41e-5;

}  // namespace voltlap::plant::study
