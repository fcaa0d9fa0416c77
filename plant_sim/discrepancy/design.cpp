// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "discrepancy/anonymous_shapes.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStep = 0.1;  // of a typical size: derivative of the linear stage

/// Empty when the column does nothing.
VectorXd without_noise(VectorXd effect) {
  for (double& v : effect) {
    if (!std::isfinite(v)) v = 0.0;
  }
  return effect.cwiseAbs().maxCoeff() > 1e-12 ? effect : VectorXd();
}

void add_columns(Design& out, int index, const Cause& cause, std::size_t number, const Form& form) {
  for (const std::size_t parameter : form.linear) {
    World world = out.model;
    std::vector<double> values = form.at;
    const double step = kStep * cause.parameters[parameter].typical;
    values[parameter] += step;
    form.apply(world, values);
    const Prediction prediction = predict(world, out.comparison);
    Column column;
    column.cause = index;
    column.form = number;
    column.parameter = parameter;
    column.key = fmt::format("{}/{}/{}/{}", cause.name, form.channel, number, parameter);
    column.balance = cause.balance;
    column.repeats = cause.parameters[parameter].repeats / cause.parameters[parameter].typical;
    bool acts = false;
    for (std::size_t c = 0; c < prediction.channels.size(); ++c) {
      column.effect.push_back(
          without_noise((prediction.channels[c] - out.base.channels[c]) * (cause.parameters[parameter].typical / step)));
      acts = acts || column.effect.back().size() > 0;
    }
    if (acts) out.columns.push_back(std::move(column));
  }
}

void add_shapes(Design& out, int index, const Cause& cause, std::size_t number, const Form& form) {
  for (std::size_t g = 0; g < out.comparison.groups.size(); ++g) {
    if (out.comparison.groups[g].stem != form.stem) continue;
    const std::vector<VectorXd> effects = form.shapes(out.model, out.comparison, out.base);
    for (std::size_t k = 0; k < effects.size(); ++k) {
      const std::size_t parameter = form.linear[k];
      const std::string key = fmt::format("{}/{}", cause.name, parameter);
      out.shapes[g].push_back({index, number, parameter, key, effects[k] * cause.parameters[parameter].typical});
    }
  }
}

}  // namespace

std::vector<VectorXd> residuals_of(const Comparison& comparison, const Prediction& prediction) {
  std::vector<VectorXd> out;
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
    out.push_back(comparison.channels[c].measured - prediction.channels[c]);
  }
  return out;
}

Design design_of(const World& model, Comparison comparison, const std::vector<Cause>& causes) {
  Design out;
  out.model = model;
  out.comparison = std::move(comparison);
  out.base = predict(model, out.comparison);
  out.residual = residuals_of(out.comparison, out.base);
  out.shapes.resize(out.comparison.groups.size());
  for (std::size_t k = 0; k < causes.size(); ++k) {
    out.forms.push_back(causes[k].forms(model, out.comparison));
    for (std::size_t number = 0; number < out.forms[k].size(); ++number) {
      const Form& form = out.forms[k][number];
      if (form.apply) {
        add_columns(out, static_cast<int>(k), causes[k], number, form);
      } else {
        add_shapes(out, static_cast<int>(k), causes[k], number, form);
      }
    }
  }
  for (Column& column : anonymous_columns(out)) out.columns.push_back(std::move(column));
  return out;
}

}  // namespace voltlap::plant
