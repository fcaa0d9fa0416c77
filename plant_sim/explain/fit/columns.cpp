// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/columns.hpp"

#include <cmath>

#include <optional>

#include "discrepancy/anonymous_shapes.hpp"
#include "discrepancy/saturation.hpp"

namespace voltlap::explain {
namespace {

constexpr double kStep = 0.1;         // of a typical size: derivative
constexpr double kNothing = 1e-9;     // of a parameter: what has no size of its own is told by its presence
constexpr double kWide = 30.0;        // typical sizes: nothing is known of a cause beforehand
constexpr double kRest_v = 1e-3;      // how well a first rest tells the open-circuit voltage
constexpr double kUnderLoad = 0.05;   // SOC, where no rest tells it
constexpr double kBestSensor = 0.02;  // of a practical size: noise that no reading is below
constexpr double kWarmth_k = 0.5;     // cells beside their thermistors at the start

/// Columns as they are collected: effects by channel.
struct Collected {
  std::vector<std::vector<VectorXd>> effect;  ///< [column][channel]
  std::vector<double> sigma, typical;
  Index add(std::vector<VectorXd> by_channel, double prior_sigma, double unit) {
    effect.push_back(std::move(by_channel));
    sigma.push_back(prior_sigma);
    typical.push_back(unit);
    return static_cast<Index>(effect.size()) - 1;
  }
};

bool acts(const std::vector<VectorXd>& by_channel) {
  for (const VectorXd& v : by_channel) {
    if (v.size() > 0) return true;
  }
  return false;
}

/// What can a cause of this kind change? Only errors of the current are seen by battery and car.
plant::Acts acts_on(plant::Balance balance, const plant::World& from, const plant::World& to) {
  if (from.current_limit_a != to.current_limit_a) return plant::Acts::kOnAll;
  if (balance == plant::Balance::kForce || balance == plant::Balance::kPower) return plant::Acts::kOnCar;
  const auto differ = [](const plant::SensorError& a, const plant::SensorError& b) {
    return a.gain != b.gain || a.offset != b.offset || a.delay_s != b.delay_s;
  };
  return differ(from.current, to.current) ? plant::Acts::kOnAll : plant::Acts::kOnBattery;
}

/// Effect of a step away from the model itself.
std::vector<VectorXd> signature(const Observed& log, const plant::World& to, plant::Balance balance, double step) {
  std::vector<VectorXd> out =
      log.effect_of(plant::predict(to, log.comparison, log.base, acts_on(balance, log.model, to)));
  for (VectorXd& v : out) v /= step;
  return out;
}

std::vector<VectorXd> derivative(const Observed& log, const plant::World& from, const plant::World& to,
                                 double step) {
  std::vector<VectorXd> out = log.effect_of(plant::predict(to, log.comparison));
  if (&from != &log.model) {
    const std::vector<VectorXd> before = log.effect_of(plant::predict(from, log.comparison));
    for (std::size_t c = 0; c < out.size(); ++c) {
      if (before[c].size() > 0) out[c] = out[c].size() > 0 ? VectorXd(out[c] - before[c]) : VectorXd(-before[c]);
    }
  }
  for (VectorXd& v : out) v /= step;
  return out;
}

/// Where the log began: how full, and how warm beside its thermistors.
void add_starts(const Observed& log, const plant::World& world, Collected& columns, std::vector<Index>& nuisances) {
  constexpr double kSocStep = 0.002, kWarmthStep = 0.2;
  plant::World changed = world;
  changed.initial_soc_change += kSocStep;
  const double known =
      log.comparison.facts.starts_at_rest ? kRest_v * 1e3 * plant::soc_per_millivolt(log.base.battery) : kUnderLoad;
  nuisances.push_back(columns.add(derivative(log, world, changed, kSocStep), known, 1.0));
  if (!plant::has_temperature(log.comparison)) return;
  changed = world;
  changed.initial_warmth_k += kWarmthStep;
  nuisances.push_back(columns.add(derivative(log, world, changed, kWarmthStep), kWarmth_k, 1.0));
}

Problem problem_of(const std::vector<const ReadChannel*>& channels, const Observed& log, const Collected& columns,
                   const std::vector<Index>& nuisances) {
  Problem out;
  out.nuisances = nuisances;
  out.blocks = log.blocks;
  out.prior_sigma = Eigen::Map<const VectorXd>(columns.sigma.data(), static_cast<Index>(columns.sigma.size()));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const ReadChannel& channel = *channels[c];
    ChannelColumns made{channel.reader.time_s(), channel.rough, {}, {}, log.blocks_of(channel)};
    for (std::size_t k = 0; k < columns.effect.size(); ++k) {
      if (columns.effect[k][c].size() > 0) made.column.push_back(static_cast<Index>(k));
    }
    made.values.resize(channel.residual.size(), static_cast<Index>(made.column.size()) + 1);
    for (std::size_t k = 0; k < made.column.size(); ++k) {
      made.values.col(static_cast<Index>(k)) = columns.effect[static_cast<std::size_t>(made.column[k])][c];
    }
    made.values.rightCols(1) = channel.residual;
    out.least_sigma.push_back(kBestSensor * channel.practical);
    out.channels.push_back(gram_of(made, noise_grid(channel.balance != plant::Balance::kHeat), log.blocks));
  }
  return out;
}

void describe(const std::vector<const ReadChannel*>& channels, const Collected& columns, Family& out) {
  for (const ReadChannel* channel : channels) {
    out.channel.push_back(channel->name);
    out.practical.push_back(channel->practical);
  }
  out.typical = Eigen::Map<const VectorXd>(columns.typical.data(), static_cast<Index>(columns.typical.size()));
}

std::vector<const ReadChannel*> pointers_to(const std::vector<ReadChannel>& channels) {
  std::vector<const ReadChannel*> out;
  for (const ReadChannel& channel : channels) out.push_back(&channel);
  return out;
}

/// The start is no finding where the log does not say what it was.
bool may_be_named(const plant::Cause& cause, const Observed& log) {
  return std::string_view(cause.name) != "initial_soc" || log.comparison.find("soc") != nullptr;
}

/// What a member begins with beside the others.
void add_member_starts(const Observed& log, const ReadChannel& channel, bool heat, Collected& columns,
                       std::vector<Index>& nuisances) {
  constexpr double kSoc = 0.01, kWarmth = 0.3;
  if (!heat) {
    nuisances.push_back(columns.add({channel.reader.of(log.base.battery.ocv_slope_v)}, kSoc, 1.0));
    return;
  }
  const plant::CellParameters& cell = log.model.car.cell;
  const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2;
  const double tau = cooling > 0.0 ? cell.mass_kg * cell.heat_capacity_j_per_kg_k / cooling : 1e9;
  const VectorXd& t = channel.reader.time_s();
  nuisances.push_back(columns.add({(-(t.array() - t(0)) / tau).exp().matrix()}, kWarmth, 1.0));
}

}  // namespace

/// The forms of a cause on this log. A current sensor that ends at a limit has no signature that is a straight
/// line: its column is the whole effect, and where its bends are followed nothing is left to estimate.
std::vector<plant::Form> forms_of(const plant::Cause& cause, const Observed& log) {
  if (std::string_view(cause.name) != "current_saturation") return cause.forms(log.model, log.comparison);
  const std::optional<plant::Rail> rail = plant::rail_of(*log.comparison.log.find("current"));
  if (!rail || log.comparison.facts.at_limit.empty()) return {};
  plant::Form form;
  form.at = {rail->limit_a};
  form.linear = {0};
  form.apply = [from_a = rail->from_a](plant::World& world, plant::Values) { world.current_limit_a = from_a; };
  return {form};
}

Family global_family(const Observed& log, const std::vector<plant::Cause>& causes) {
  Family out;
  Collected columns;
  std::vector<Index> nuisances;
  add_starts(log, log.model, columns, nuisances);
  for (std::size_t k = 0; k < causes.size(); ++k) {
    if (!may_be_named(causes[k], log)) continue;
    const std::vector<plant::Form> forms = forms_of(causes[k], log);
    for (std::size_t number = 0; number < forms.size(); ++number) {
      const plant::Form& form = forms[number];
      if (!form.apply) continue;
      Suspect suspect{static_cast<int>(k), form, number, causes[k].name, form.channel, {}};
      for (const std::size_t p : form.linear) {
        plant::World world = log.model;
        std::vector<double> values = form.at;
        const bool whole = form.refined.empty();  // no step: the effect is there or not
        const double typical = whole ? kNothing : causes[k].parameters[p].typical;
        values[p] += kStep * typical;
        form.apply(world, values);
        std::vector<VectorXd> effect = signature(log, world, causes[k].balance, whole ? 1.0 : kStep);
        if (acts(effect)) suspect.columns.push_back(columns.add(std::move(effect), kWide, typical));
      }
      if (suspect.columns.size() == form.linear.size()) out.suspects.push_back(std::move(suspect));
    }
  }
  const std::vector<const ReadChannel*> channels = pointers_to(log.channels);
  out.problem = problem_of(channels, log, columns, nuisances);
  describe(channels, columns, out);
  return out;
}

Family member_family(const Observed& log, const Member& member, const std::vector<plant::Cause>& causes) {
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
      const std::vector<VectorXd> shapes = form.shapes(log.model, log.comparison, log.base);
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        const double typical = causes[k].parameters[form.linear[s]].typical;
        const VectorXd known = shapes[s].array().isFinite().select(shapes[s], 0.0);
        suspect.columns.push_back(columns.add({member.channel.reader.of(known) * typical}, kWide, typical));
      }
      out.suspects.push_back(std::move(suspect));
    }
  }
  out.problem = problem_of({&member.channel}, log, columns, nuisances);
  describe({&member.channel}, columns, out);
  return out;
}

Family at_values(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family,
                 const SetValues& at) {
  Family out = family;
  plant::World world = log.model;
  for (std::size_t k = 0; k < at.members.size(); ++k) out.suspects[at.members[k]].form.apply(world, at.values[k]);
  const std::vector<VectorXd> moved = log.effect_of(plant::predict(world, log.comparison));
  std::vector<ReadChannel> channels = log.channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (moved[c].size() > 0) channels[c].residual -= moved[c];
  }
  Collected columns;
  std::vector<Index> nuisances;
  add_starts(log, world, columns, nuisances);
  for (std::size_t k = 0; k < at.members.size(); ++k) {
    Suspect& suspect = out.suspects[at.members[k]];
    suspect.columns.clear();
    const plant::Cause& cause = causes[static_cast<std::size_t>(suspect.cause)];
    for (const std::size_t p : suspect.form.refined) {
      plant::World stepped = log.model;
      for (std::size_t m = 0; m < at.members.size(); ++m) {
        std::vector<double> values = at.values[m];
        if (m == k) values[p] += kStep * cause.parameters[p].typical;
        out.suspects[at.members[m]].form.apply(stepped, values);
      }
      suspect.columns.push_back(
          columns.add(derivative(log, world, stepped, kStep), kWide, cause.parameters[p].typical));
    }
  }
  out.problem = problem_of(pointers_to(channels), log, columns, nuisances);
  out.channel.clear();
  out.practical.clear();
  describe(pointers_to(channels), columns, out);
  return out;
}

}  // namespace voltlap::explain
