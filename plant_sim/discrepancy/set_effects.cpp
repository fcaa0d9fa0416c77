// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/set_effects.hpp"

#include <algorithm>

namespace voltlap::plant {

using Eigen::Index;
using Eigen::VectorXd;

Effects effects_of(const Judged& j, const std::vector<RefinedCause>& causes) {
  Effects out;
  World world = j.design.model;
  for (const VectorXd& base : j.design.base.channels) out.channels.push_back(VectorXd::Zero(base.size()));
  for (const Group& group : j.design.comparison.groups) {
    out.members.emplace_back(group.members.size(), VectorXd::Zero(j.design.comparison.log.rows()));
  }
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
    const auto g = static_cast<std::size_t>(c.group);
    for (std::size_t k = 0; k < c.shapes.size(); ++k) {
      const double size = fit.values[c.parameters[k]] / cause_of(j, fit.candidate).parameters[c.parameters[k]].typical;
      const VectorXd shape = size * j.design.shapes[g][static_cast<std::size_t>(c.shapes[k])].effect;
      const double share = static_cast<double>(c.members.size()) / static_cast<double>(out.members[g].size());
      for (std::size_t m = 0; m < out.members[g].size(); ++m) {
        const bool own = std::count(c.members.begin(), c.members.end(), static_cast<Index>(m)) > 0;
        out.members[g][m] += shape * ((own ? 1.0 : 0.0) - share);
      }
      const Column& column = j.design.columns[static_cast<std::size_t>(c.rows[k])];
      for (std::size_t n = 0; n < column.effect.size(); ++n) {
        if (column.effect[n].size() > 0) out.channels[n] += size * column.effect[n];
      }
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

}  // namespace voltlap::plant
