// SPDX-License-Identifier: Apache-2.0
// What an effect has to be before it is of use, by channel, in practical sizes: by how well the log's own instruments
// and rows let it be known.
#pragma once
#include <vector>

#include "explain/decide/usual.hpp"
#include "explain/model/observed.hpp"

namespace voltlap::explain {

inline constexpr double kAlone = 2.0;  ///< practical sizes, where no reference tells how well the model does

/// Does only a sound drive tell how well a balance is known? Of tyres and brakes always, of the motor's power where
/// its torque was not recorded, or its speed neither.
[[nodiscard]] bool is_known_by_sound(const Observed& log, plant::Balance balance);

/// What is of use where no sound drive tells how well the model does: of tyres and brakes, and of heat behind
/// coarse steps, of which few may have been passed, twice what is worth a word; of heat under air that is known in
/// coarse steps three times that.
[[nodiscard]] std::vector<double> asked_alone(const Observed& log);

/// What is of use beside references: they lost as much between their rows, but not the same. Of a voltage of the
/// current's time no more than is wrong in them: a resistance shows in each row, whatever flowed before it. What flowed
/// between rows heats one drive more than another. Empty where no channel lost what is worth a word.
[[nodiscard]] std::vector<double> asked_between_rows(const Observed& log, const Asked& sound);

}  // namespace voltlap::explain
