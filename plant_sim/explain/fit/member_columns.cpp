// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "explain/fit/collected.hpp"

namespace voltlap::explain {
namespace {

/// What a member begins with beside the others, and again after each gap.
void add_member_starts(const Observed& log, const ReadChannel& channel, bool heat, Collected& columns,
                       std::vector<Index>& nuisances) {
  constexpr double kSoc = 0.01, kWarmth = 0.3, kOfTurn = 0.3;
  const plant::CellParameters& cell = log.model.car.cell;
  const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2;
  const double tau = cooling > 0.0 ? cell.mass_kg * cell.heat_capacity_j_per_kg_k / cooling : 1e9;
  std::vector<Index> from = log.comparison.facts.gaps;
  from.insert(from.begin(), 0);
  for (const Index row : from) {
    const VectorXd& time_s = log.comparison.log.time_s;
    const Index left = time_s.size() - row;
    VectorXd shape = VectorXd::Zero(time_s.size());
    if (heat) {
      shape.tail(left) = (-(time_s.tail(left).array() - time_s(row)) / tau).exp();
    } else {
      shape.tail(left) = log.base.battery.ocv_slope_v.tail(left);
    }
    nuisances.push_back(columns.add({channel.reader.of(shape)}, heat ? kWarmth : kSoc, 1.0));
  }
  // Of cells that are read in turn a bus says when a value was sent, within a turn, not when it was measured; and a
  // table says it within a row.
  if (!heat && (log.read.age_s.contains(channel.name) || log.read.cells_at_rows)) {
    constexpr double kStep_s = 0.05;
    const VectorXd& volts = log.base.battery.voltage_v;
    const VectorXd late = (plant::shifted(log.comparison.log.time_s, volts, -kStep_s) - volts) / kStep_s;
    nuisances.push_back(
        columns.add({channel.reader.of(late)}, kOfTurn * usual_interval_s(log.read, channel.name), 1.0));
  }
}

Family family_of_member(const Observed& log, const Member& member, const std::vector<plant::Cause>& causes,
                        const Wanted& wanted, Noises noises) {
  Family out;
  Collected columns;
  std::vector<Index> nuisances;
  const plant::Group& group = log.comparison.groups[member.group];
  add_member_starts(log, member.channel, group.balance == plant::Balance::kHeat, columns, nuisances);
  for (std::size_t k = 0; k < causes.size(); ++k) {
    const std::vector<plant::Form> forms = causes[k].forms(log.model, log.comparison);
    for (std::size_t number = 0; number < forms.size(); ++number) {
      const plant::Form& form = forms[number];
      if (form.apply || form.stem != group.stem || form.channel == "ends") continue;
      Suspect suspect{static_cast<int>(k), form, number, causes[k].name, group.members[member.index], {}};
      if (!wanted(suspect)) continue;
      const std::vector<VectorXd> shapes = form.shapes(log.model, log.comparison, log.base);
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        const double typical = causes[k].parameters[form.linear[s]].typical;
        const VectorXd effect = member.channel.reader.of(filled(shapes[s])) * typical;
        suspect.columns.push_back(columns.add({effect}, kWide, typical));
      }
      out.suspects.push_back(std::move(suspect));
    }
  }
  out.problem = problem_of({&member.channel}, log, columns, nuisances, noises);
  describe({&member.channel}, columns, out);
  return out;
}

}  // namespace

Family member_family(const Observed& log, const Member& member, const std::vector<plant::Cause>& causes,
                     const Wanted& wanted) {
  return family_of_member(log, member, causes, wanted, Noises::kAll);
}

double most_of_member(const Observed& log, const Member& member, const std::vector<plant::Cause>& causes) {
  if (member.channel.reader.size() == 0) return 0.0;  // never read together with the others
  const Family family = family_of_member(log, member, causes, all_suspects, Noises::kWhite);
  const Products& plain = family.problem.channels[0].all[0];
  const Index all = plain.gram.rows() - 1, starts = std::ssize(family.problem.nuisances);
  const auto taken = [&](Index columns) {
    MatrixXd normal = plain.gram.topLeftCorner(columns, columns);
    normal.diagonal() *= 1.0 + 1e-9;  // columns that are alike
    normal.diagonal().array() += 1e-30;
    const VectorXd right = plain.gram.row(all).head(columns).transpose();
    return right.dot(normal.ldlt().solve(right));
  };
  return std::sqrt(std::max(0.0, taken(all) - taken(starts)) / std::max(1.0, plain.count)) / family.practical[0];
}

VectorXd member_effect(const plant::Form& form, const Observed& log, const std::vector<double>& values) {
  VectorXd out = VectorXd::Zero(log.comparison.log.rows());
  if (form.curved) {
    out = form.curved(log.model, log.comparison, log.base, values);
  } else {
    const std::vector<VectorXd> shapes = form.shapes(log.model, log.comparison, log.base);
    for (std::size_t s = 0; s < shapes.size(); ++s) out += values[form.linear[s]] * shapes[s];
  }
  return filled(std::move(out));
}

Family member_at_values(const Observed& log, const Member& member, const std::vector<plant::Cause>& causes,
                        const Family& family, const SetValues& at) {
  Family out;
  out.suspects = family.suspects;
  ReadChannel left = member.channel;
  const bool heat = log.comparison.groups[member.group].balance == plant::Balance::kHeat;
  Collected columns;
  std::vector<Index> nuisances;
  add_member_starts(log, member.channel, heat, columns, nuisances);
  for (std::size_t k = 0; k < at.members.size(); ++k) {
    Suspect& suspect = out.suspects[at.members[k]];
    suspect.columns.clear();
    const VectorXd here = member_effect(suspect.form, log, at.values[k]);
    left.residual -= member.channel.reader.of(here);
    const plant::Cause& cause = causes[static_cast<std::size_t>(suspect.cause)];
    for (const std::size_t p : suspect.form.refined) {
      std::vector<double> values = at.values[k];
      values[p] += kStep * cause.parameters[p].typical;
      const VectorXd by_row = (member_effect(suspect.form, log, values) - here) / kStep;
      suspect.columns.push_back(
          columns.add({member.channel.reader.of(by_row)}, kWide, cause.parameters[p].typical));
    }
  }
  out.problem = problem_of({&left}, log, columns, nuisances);
  out.problem.most_slow = family.problem.most_slow;
  describe({&left}, columns, out);
  return out;
}

}  // namespace voltlap::explain
