// SPDX-License-Identifier: Apache-2.0
// What an effect has to be before it is of use, by channel, in practical sizes: by how well the log's own instruments
// and rows let it be known.
#pragma once
#include <vector>

#include "explain/model/observed.hpp"

namespace voltlap::explain {

inline constexpr double kAlone = 2.0;  ///< practical sizes, where no reference tells how well the model does

/// Does only a sound drive tell how well a balance is known? Of tyres and brakes always, of the motor's power where
/// its torque was not recorded, or its speed neither.
[[nodiscard]] bool is_known_by_sound(const Observed& log, plant::Balance balance);

/// What is of use where no sound drive tells how well the model does: of tyres and brakes, and of heat behind
/// coarse steps, of which few may have been passed, twice what is worth a word; of heat under air that is known in
/// coarse steps three times that; of rows far apart twice what these may have lost.
[[nodiscard]] std::vector<double> asked_alone(const Observed& log);

/// What is of use beside references: they lost as much between their rows, but not the same. Empty where no channel
/// lost what is worth a word.
[[nodiscard]] std::vector<double> asked_between_rows(const Observed& log);

}  // namespace voltlap::explain
