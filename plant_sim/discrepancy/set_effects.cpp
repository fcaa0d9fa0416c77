// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/set_effects.hpp"

#include <algorithm>

#include "discrepancy/member_effect.hpp"

namespace voltlap::plant {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

Effects no_effects(const Comparison& on) {
  const VectorXd nothing = VectorXd::Zero(on.log.rows());
  Effects out{std::vector<VectorXd>(on.channels.size(), nothing), {}};
  for (const Group& group : on.groups) out.members.emplace_back(group.members.size(), nothing);
  return out;
}

/// `size` typical sizes of the signature `k` of a candidate: on the channels, and on the members that it is of.
void add_signature(const Judged& j, const Candidate& c, std::size_t k, double size, Effects& out) {
  const Column& column = j.design.columns[static_cast<std::size_t>(c.rows[k])];
  for (std::size_t n = 0; n < column.effect.size(); ++n) {
    if (column.effect[n].size() > 0) out.channels[n] += size * column.effect[n];
  }
  if (c.group < 0) return;
  const auto g = static_cast<std::size_t>(c.group);
  const VectorXd shape = size * j.design.shapes[g][static_cast<std::size_t>(c.shapes[k])].effect;
  const double share = static_cast<double>(c.members.size()) / static_cast<double>(out.members[g].size());
  for (std::size_t m = 0; m < out.members[g].size(); ++m) {
    const bool own = std::count(c.members.begin(), c.members.end(), static_cast<Index>(m)) > 0;
    out.members[g][m] += shape * ((own ? 1.0 : 0.0) - share);
  }
}

/// A cause in some members of group `g` of another log: on them, and on the mean that all members share.
void add_to_members(const Judged& j, const Candidate& c, const Form& form, const RefinedCause& fit,
                    const Comparison& other, const Prediction& base, std::size_t g, Effects& out) {
  const auto& names = j.design.comparison.groups[static_cast<std::size_t>(c.group)].members;
  const Group& group = other.groups[g];
  VectorXd effect = VectorXd::Zero(other.log.rows());
  if (form.curved) {
    effect = form.curved(j.design.model, other, base, fit.values);
  } else {
    const std::vector<VectorXd> shapes = form.shapes(j.design.model, other, base);
    for (std::size_t k = 0; k < shapes.size(); ++k) effect += fit.values[form.linear[k]] * shapes[k];
  }
  double found = 0.0;
  for (const Index member : c.members) {
    const auto at = std::find(group.members.begin(), group.members.end(), names[static_cast<std::size_t>(member)]);
    if (at == group.members.end()) continue;
    out.members[g][static_cast<std::size_t>(at - group.members.begin())] += effect;
    found += 1.0;
  }
  const VectorXd mean = effect * (found / static_cast<double>(group.members.size()));
  for (VectorXd& member : out.members[g]) member -= mean;
  if (found == 0.0) return;
  const std::vector<VectorXd> shown = member_effect(j.design.model, other, base, group, effect,
                                                    static_cast<std::size_t>(found), form.of_sensor);
  for (std::size_t n = 0; n < shown.size(); ++n) {
    if (shown[n].size() > 0) out.channels[n] += shown[n];
  }
}

}  // namespace

Effects effects_of(const Judged& j, const std::vector<RefinedCause>& causes) {
  Effects out = no_effects(j.design.comparison);
  World world = j.design.model;
  bool global = false;
  for (const RefinedCause& fit : causes) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.cause < 0) continue;
    const Form& form = j.design.forms[static_cast<std::size_t>(c.cause)][c.form];
    if (form.apply) {
      form.apply(world, fit.values);
      global = true;
      continue;
    }
    if (form.curved) {
      add_to_members(j, c, form, fit, j.design.comparison, j.design.base, static_cast<std::size_t>(c.group), out);
      continue;
    }
    for (std::size_t k = 0; k < c.shapes.size(); ++k) {
      add_signature(j, c, k, fit.values[c.parameters[k]] / cause_of(j, fit.candidate).parameters[c.parameters[k]].typical,
                    out);
    }
  }
  if (global) {
    const Prediction prediction = predict(world, j.design.comparison);
    for (std::size_t c = 0; c < out.channels.size(); ++c) {
      out.channels[c] += prediction.channels[c] - j.design.base.channels[c];
    }
  }
  return out;
}

Effects linear_effects(const Judged& j, const std::vector<std::size_t>& members, const VectorXd& sizes) {
  Effects out = no_effects(j.design.comparison);
  Index at = 0;
  for (const std::size_t m : members) {
    const Candidate& c = j.system.candidates[m];
    for (std::size_t k = 0; k < c.rows.size(); ++k) add_signature(j, c, k, sizes(at++), out);
  }
  return out;
}

Effects effects_on(const Judged& j, const std::vector<RefinedCause>& causes, const Comparison& other) {
  const Prediction base = predict(j.design.model, other);
  Effects out = no_effects(other);
  World world = j.design.model;
  for (const RefinedCause& fit : causes) {
    const Candidate& c = j.system.candidates[fit.candidate];
    if (c.cause < 0) continue;
    const Form& form = j.design.forms[static_cast<std::size_t>(c.cause)][c.form];
    if (form.apply) {
      form.apply(world, fit.values);
      continue;
    }
    for (std::size_t g = 0; g < other.groups.size(); ++g) {
      if (other.groups[g].stem != form.stem) continue;
      add_to_members(j, c, form, fit, other, base, g, out);
    }
  }
  world.initial_soc_change = j.design.model.initial_soc_change;
  const Prediction prediction = predict(world, other);
  for (std::size_t c = 0; c < out.channels.size(); ++c) out.channels[c] += prediction.channels[c] - base.channels[c];
  return out;
}

}  // namespace voltlap::plant
