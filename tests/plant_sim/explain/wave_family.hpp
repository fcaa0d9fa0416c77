// SPDX-License-Identifier: Apache-2.0
// A simulated channel as the family of one cause, for tests of what is decided of it.
#pragma once
#include "explain/fit/columns.hpp"
#include "simulated_channel.hpp"

namespace voltlap::explain {

/// One channel, and a cause that is its wave.
inline Family family_of(const SimulatedChannel& channel, const char* name) {
  Family out;
  out.problem = channel.problem();
  Suspect suspect;
  suspect.cause = 0;
  suspect.name = "wave";
  suspect.form.at = {0.0};
  suspect.form.linear = suspect.form.refined = {0};
  suspect.columns = {1};
  out.suspects = {suspect};
  out.channel = {name};
  out.practical = {1.0};
  out.typical = VectorXd::Ones(3);
  return out;
}

}  // namespace voltlap::explain
