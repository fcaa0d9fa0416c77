// SPDX-License-Identifier: Apache-2.0
// What every cause would change in every channel, a column for each of its numbers, in typical sizes of the number;
// and the nuisances that every hypothesis has: where the log began.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "explain/causes/cause.hpp"
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
  bool is_law_of_resistance = false;  ///< as in the catalogue
};

/// One family of hypotheses: what they are fitted to and of what they are made.
struct Family {
  Problem problem;
  std::vector<Suspect> suspects;
  std::vector<std::string> channel;  ///< of problem.channels
  std::vector<double> practical;     ///< of each
  std::vector<double> apart;         ///< of each: practical sizes that readings between rows may be off; empty: none
  std::vector<double> asked;         ///< of each: practical sizes that are of use there; empty: one
  VectorXd typical;                  ///< size of one unit of each column, in the parameter's unit
};

/// Changes how a world begins, and begins again after gaps, by the sizes of the nuisances of a global family.
void begin_at(plant::World& world, const Observed& log, const VectorXd& starts);
/// Those of the starts whose effect is no straight line: charges. The others are told by the model that they were
/// fitted in.
[[nodiscard]] VectorXd bending_starts(const Observed& log, VectorXd starts);
/// Takes from what a log was moved by, by channel, what these starts add as straight lines from where the model as
/// given begins: the nuisances of all families are these lines.
void take_straight_starts(const Observed& log, const VectorXd& starts, std::vector<VectorXd>& moved);
/// Which suspects are asked for.
using Wanted = std::function<bool(const Suspect&)>;
/// Everything that acts on the whole car. `causes`: the catalogue.
[[nodiscard]] Family global_family(const Observed& log, const std::vector<plant::Cause>& causes,
                                   const Wanted& wanted);
/// What can be wrong with one cell or thermistor alone.
[[nodiscard]] Family member_family(const Observed& log, const Member& member,
                                   const std::vector<plant::Cause>& causes, const Wanted& wanted);
/// Can anything of that be of practical use? RMS that all of its columns together take by plain least squares
/// beside where the member began, in practical sizes.
[[nodiscard]] double most_of_member(const Observed& log, const Member& member,
                                    const std::vector<plant::Cause>& causes);
[[nodiscard]] inline bool all_suspects(const Suspect& /*any*/) {
  return true;
}
/// The same cause in the same form: of the same channel, or, of one member, of any.
[[nodiscard]] bool is_same(const Suspect& a, const Suspect& b);

/// The same family where a set of suspects has these values: the residual that is left, their columns there, and
/// the nuisances. The suspects keep their numbers; all others are gone.
struct SetValues {
  std::vector<std::size_t> members;         ///< of family.suspects
  std::vector<std::vector<double>> values;  ///< all parameters of each
  VectorXd starts;                          ///< where the log began beside them: bends are followed from there
};
[[nodiscard]] Family at_values(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family,
                               const SetValues& at);
/// The same of one member's family.
[[nodiscard]] Family member_at_values(const Observed& log, const Member& member,
                                      const std::vector<plant::Cause>& causes, const Family& family,
                                      const SetValues& at);
/// What a cause of one member of these values puts into its readings, by row.
[[nodiscard]] VectorXd member_effect(const plant::Form& form, const Observed& log,
                                     const std::vector<double>& values);

}  // namespace voltlap::explain
