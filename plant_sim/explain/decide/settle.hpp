// SPDX-License-Identifier: Apache-2.0
// How a log begins where it does not say so: after a drive that is not in it, or as warm as nobody measured. Both are
// weighed beside what is found then, as one may look like the other.
#pragma once
#include <deque>
#include <vector>

#include "explain/decide/rounds.hpp"

namespace voltlap::explain {

/// A log of which nothing is wrong but perhaps how it begins.
[[nodiscard]] Held held_sound(const plant::World& model, plant::Recording log, Holding how);

/// Does it begin after a drive? `how` is then what it is held as.
void settle_beginning(Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                      Holding& how, std::deque<Round>& rounds);

/// As warm as what is found asks for, where nobody says how warm the battery was.
void settle_warmth(Held& log, const std::vector<Held>& references, const std::vector<plant::Cause>& causes,
                   Holding how, std::deque<Round>& rounds);

}  // namespace voltlap::explain
