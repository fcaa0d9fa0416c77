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
      const CauseParameter& p = cause.parameters[parameter];
      const std::string key = fmt::format("{}/{}", cause.name, parameter);
      // Another form of the cause may have the same shape: sound members differ by it once.
      const bool again = std::any_of(out.shapes[g].begin(), out.shapes[g].end(), [&](const Shape& s) { return s.key == key; });
      out.shapes[g].push_back({index, number, parameter, key, again ? 0.0 : p.spread / p.typical,
                               again ? 0.0 : std::max(p.repeats, p.repeats_of_member) / p.typical, effects[k] * p.typical});
    }
  }
}

/// Cells do not begin equally full nor equally warm, and the ends of a row stay cooler: what sound members differ by.
/// How much they differ by, and how much of it changes from log to log: by the likelihood of sound logs of the bank.
void add_member_shapes(Design& out) {
  constexpr double kSoc = 0.01, kPerKelvin = 0.02, kTenKelvin = 10.0, kCore = 150.0;
  const BatteryResponse& b = out.base.battery;
  const CellParameters& cell = out.model.car.cell;
  const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2;
  const double tau = cooling > 0.0 ? cell.mass_kg * cell.heat_capacity_j_per_kg_k / cooling : 1e9;
  const VectorXd& time = out.comparison.log.time_s;
  const VectorXd fades = (-(time.array() - time(0)) / tau).exp().matrix();
  const VectorXd rise = (b.temperature_c.array() - b.temperature_c(0)).matrix() / kTenKelvin;
  for (std::size_t g = 0; g < out.comparison.groups.size(); ++g) {
    const auto add = [&](const std::string& key, double spread, double repeats, const VectorXd& effect) {
      out.shapes[g].push_back({-1, 0, 0, key, spread, repeats, effect});
    };
    if (out.comparison.groups[g].balance == Balance::kHeat) {
      add("member/warmth", 0.03, 0.2, fades);
      add("member/warming", 0.05, 0.03, rise);
    } else {
      add("member/soc", 0.03, 0.1, kSoc * b.ocv_slope_v);
      // Beside the resistance that the cell has on the whole, which is the weak cell's: only how it changes.
      const auto changing = [&](const VectorXd& with) {
        const VectorXd shape = b.drop_v.cwiseProduct(with);
        return VectorXd(kPerKelvin * (shape - b.drop_v * (shape.dot(b.drop_v) / std::max(1e-12, b.drop_v.squaredNorm()))));
      };
      add("member/warmth", 0.4, 1.3, changing(fades));
      add("member/warming", 18.0, 2.0, changing(rise));
      // The core is warmer than what the rise of the mean tells.
      const VectorXd heat = b.drop_v.cwiseProduct(b.current_a) / std::max(1e-9, (b.drop_v.cwiseProduct(b.current_a)).mean());
      add("member/heat", 0.5, 0.13, changing(lagged(time, heat, kCore)));
    }
  }
}

/// The first rest tells the open-circuit voltage to about 0.7 mV: the charge by how steep that is there.
void add_start(Design& out) {
  constexpr double kTypical = 0.01, kKnownMv = 0.7, kStepOfSoc = 0.002;
  World world = out.model;
  world.initial_soc_change += kStepOfSoc;
  const Prediction prediction = predict(world, out.comparison);
  Column column;
  column.key = "start/soc";
  column.balance = Balance::kCharge;
  column.free = kKnownMv * soc_per_millivolt(out.base.battery) / kTypical;
  for (std::size_t c = 0; c < prediction.channels.size(); ++c) {
    column.effect.push_back(without_noise((prediction.channels[c] - out.base.channels[c]) * (kTypical / kStepOfSoc)));
  }
  out.columns.push_back(std::move(column));
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
  add_member_shapes(out);
  if (out.comparison.facts.starts_at_rest) add_start(out);
  for (Column& column : anonymous_columns(out)) out.columns.push_back(std::move(column));
  return out;
}

}  // namespace voltlap::plant
