// SPDX-License-Identifier: Apache-2.0
// Names and numbers as people read them.
#pragma once
#include <Eigen/Dense>
#include <string>

#include "explain/explanation.hpp"

namespace voltlap::plant {

/// Decimals that an interval of this half width calls for.
[[nodiscard]] int decimals_of(double half);

/// "cell 7" for cell_voltage_7, "pack voltage" for pack_voltage.
[[nodiscard]] std::string channel_words(const std::string& channel);

/// The unit in which a number of this size [SI] is read: millivolts of less than half a volt, percents of a share.
struct ShownUnit {
  double scale = 1.0;
  std::string unit;
};
[[nodiscard]] ShownUnit shown_unit(const std::string& unit, double size);

/// "with it, 9.4 become 0.3 mV of voltage error ..." of the channel that gains most; empty: none gains.
[[nodiscard]] std::string gain_text(const Explanation& out);

/// RMS of the rows that are compared, those with a value; 0 where there are none.
[[nodiscard]] double rms_of(const Eigen::VectorXd& values);

}  // namespace voltlap::plant
