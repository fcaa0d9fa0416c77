// SPDX-License-Identifier: Apache-2.0
// What every cause would change in every channel, a column for each of its numbers, in typical sizes of the number;
// and the nuisances that every hypothesis has: where the log began.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/cause.hpp"
#include "explain/fit/hypothesis.hpp"
#include "explain/model/observed.hpp"

namespace voltlap::explain {

/// A cause in one of its forms, that can be part of an explanation.
struct Suspect {
  int cause = -1;  ///< of the catalogue; -1: shapes without a name
  plant::Form form;
  std::size_t number = 0;      ///< of the form
  std::string name, channel;   ///< channel or member that is wrong; empty: all
  std::vector<Index> columns;  ///< one for each of form.linear
};

/// One family of hypotheses: what they are fitted to and of what they are made.
struct Family {
  Problem problem;
  std::vector<Suspect> suspects;
  std::vector<std::string> channel;  ///< of problem.channels
  std::vector<double> practical;     ///< of each
  VectorXd typical;                  ///< size of one unit of each column, in the parameter's unit
};

/// Everything that acts on the whole car. `causes`: the catalogue.
[[nodiscard]] Family global_family(const Observed& log, const std::vector<plant::Cause>& causes);
/// What can be wrong with one cell or thermistor alone.
[[nodiscard]] Family member_family(const Observed& log, const Member& member,
                                   const std::vector<plant::Cause>& causes);

/// The same family where a set of suspects has these values: the residual that is left, their columns there, and
/// the nuisances. The suspects keep their numbers; all others are gone.
struct SetValues {
  std::vector<std::size_t> members;         ///< of family.suspects
  std::vector<std::vector<double>> values;  ///< all parameters of each
};
[[nodiscard]] Family at_values(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family,
                               const SetValues& at);

}  // namespace voltlap::explain
