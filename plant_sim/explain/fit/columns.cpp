// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/columns.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>

#include "explain/fit/collected.hpp"
#include "explain/gate/rail.hpp"
#include "explain/model/settled_temperature.hpp"
#include "explain/model/unstepped.hpp"

namespace voltlap::explain {
namespace {

using plant::Acts;

constexpr double kNothing = 1e-9;    // of a parameter: what has no size of its own is told by its presence
constexpr double kRest_v = 1e-3;     // how well a first rest tells the open-circuit voltage
constexpr double kUnderLoad = 0.05;  // SOC, where no rest tells it
constexpr double kWarmth_k = 0.5;    // cells beside their thermistors at the start
constexpr double kSeason_k = 8.0;    // a battery that nobody measured, beside what the model's file says
constexpr double kCounted = 0.01;    // SOC: how well whoever counts it knew where it began
constexpr double kOfRow = 0.3;       // from one row to the next: when cells of a table were read
constexpr double kOfMoved = 0.5;     // of what moves between rows: how much the cells may have moved before or after
constexpr double kAir_k = 1.0;       // beside the model, where the log does not say it

bool acts(const std::vector<VectorXd>& by_channel) {
  for (const VectorXd& v : by_channel) {
    if (v.size() > 0) return true;
  }
  return false;
}

/// What can a cause of this kind change? Only errors of the current are seen by battery and car.
Acts acts_on(plant::Balance balance, const plant::World& from, const plant::World& to) {
  if (from.current_limit_a != to.current_limit_a) return Acts::kOnAll;
  if (balance == plant::Balance::kForce || balance == plant::Balance::kPower) return Acts::kOnCar;
  const auto differ = [](const plant::SensorError& a, const plant::SensorError& b) {
    return a.gain != b.gain || a.offset != b.offset || a.delay_s != b.delay_s;
  };
  return differ(from.current, to.current) ? Acts::kOnAll : Acts::kOnBattery;
}

plant::Prediction predicted(const Observed& log, const plant::World& world, Acts acts) {
  return plant::predict(world, log.comparison, log.base, acts);
}

/// What was reckoned once of this log is not reckoned again: `key` says what was changed.
const std::vector<VectorXd>& known(const Observed& log, const std::string& key,
                                   const std::function<std::vector<VectorXd>()>& reckon) {
  const auto found = log.known->find(key);
  return found != log.known->end() ? found->second : log.known->emplace(key, reckon()).first->second;
}

/// What can a set of them change?
Acts acts_of(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family,
             const std::vector<std::size_t>& members, const plant::World& world) {
  std::optional<Acts> out;
  for (const std::size_t m : members) {
    const Acts own = acts_on(causes[static_cast<std::size_t>(family.suspects[m].cause)].balance, log.model, world);
    out = !out || *out == own ? own : Acts::kOnAll;
  }
  return out.value_or(Acts::kOnAll);
}

/// (to - from) / step; what is empty is nothing.
std::vector<VectorXd> slope(std::vector<VectorXd> to, const std::vector<VectorXd>& from, double step) {
  for (std::size_t c = 0; c < to.size(); ++c) {
    if (!from.empty() && from[c].size() > 0)
      to[c] = to[c].size() > 0 ? VectorXd(to[c] - from[c]) : VectorXd(-from[c]);
    to[c] /= step;
  }
  return to;
}

void forget_heat(const Observed& log, std::vector<VectorXd>& effect) {
  for (std::size_t c = 0; c < effect.size(); ++c) {
    if (log.channels[c].balance == plant::Balance::kHeat) effect[c] = VectorXd();
  }
}

/// Where no voltage of its time says what heats the cells, nothing tells a cause of the heat from a resistance.
void forget_guessed_heat(const Observed& log, std::vector<VectorXd>& effect) {
  if (!log.comparison.log.has_voltage_of_its_time()) forget_heat(log, effect);
}

/// Effect of a cause: of a step away from the model itself.
std::vector<VectorXd> signature(const Observed& log, const plant::World& to, plant::Balance balance, double step) {
  std::vector<VectorXd> out = slope(log.effect_of(predicted(log, to, acts_on(balance, log.model, to))), {}, step);
  forget_guessed_heat(log, out);
  return out;
}

/// What a log does not say of how it began, by kind.
struct Start {
  double step = 0.0, sigma = 0.0;
  void (*apply)(plant::World&, const Start&, double) = nullptr;
  std::size_t gap = 0;  ///< or, of branches, 0 where the log begins and 1 after its first gap
  std::size_t branch = 0;
  bool is_of_voltage = false;  ///< what little heat it makes is no measure of it
  bool bends = false;          ///< a charge: the open-circuit voltage is no straight line
};

void charge_branch(plant::World& world, const Start& start, double by_a) {
  world.charged_by_a.resize(std::max(world.charged_by_a.size(), start.gap + 1));
  world.charged_by_a[start.gap][start.branch] += by_a;
}

/// Nobody knows what was drawn before a log that begins in a drive, nor in a gap: any current of the drive, in each
/// branch of the circuit another, as each remembers another while.
void add_branches(const Observed& log, std::vector<Start>& out) {
  const plant::LogFacts& facts = log.comparison.facts;
  const double usual_a = std::sqrt(log.base.battery.current_a.squaredNorm() /
                                   std::max(1.0, static_cast<double>(log.base.battery.current_a.size())));
  if (!(usual_a > 0.0)) return;
  for (std::size_t start = log.begins_charged ? 0 : 1; start <= facts.gaps.size(); ++start) {
    for (std::size_t branch = 0; branch < log.model.car.cell.branch_count(); ++branch) {
      out.push_back({usual_a, usual_a, charge_branch, start, branch, true});
    }
  }
}

/// Then it is known within a few kelvin alone.
bool says_no_air(const Observed& log) {
  const plant::LogFacts& facts = log.comparison.facts;
  return plant::has_temperature(log.comparison) && facts.ambient_above_model_k.size() == 0 && facts.air_step_k == 0.0;
}

/// How well the air is known [K], 0: as well as the thermistors. Coarse steps say it within half of one.
double air_doubt_k(const Observed& log) {
  constexpr double kHalfStep = 1.0 / 6;  // three standard deviations are as far as a start can be
  if (!plant::has_temperature(log.comparison)) return 0.0;
  if (says_no_air(log)) return kAir_k;
  const VectorXd* air = log.comparison.log.find("ambient");
  if (air == nullptr) return kHalfStep * log.comparison.facts.air_step_k;
  return is_coarse(*air) ? kHalfStep * least_change(*air) : 0.0;
}

/// How much of what the voltage moves it moves between two rows.
double changed_between_rows(const Observed& log) {
  const VectorXd& volts = log.base.battery.voltage_v;
  const double moves = (volts.array() - volts.mean()).matrix().squaredNorm();
  const double changes = (volts.tail(volts.size() - 1) - volts.head(volts.size() - 1)).squaredNorm();
  return moves > 0.0 ? std::min(1.0, std::sqrt(changes / moves)) : 0.0;
}

std::vector<Start> starts_of(const Observed& log) {
  const plant::LogFacts& facts = log.comparison.facts;
  const bool rests = facts.starts_at_rest && !log.begins_charged;
  const double known = rests ? kRest_v * 1e3 * plant::soc_per_millivolt(log.base.battery) : kUnderLoad;
  std::vector<Start> out{
      {0.002, known, [](plant::World& w, const Start&, double by) { w.initial_soc_change += by; }, 0, 0, true,
       true}};
  const auto warm = [](plant::World& w, const Start&, double by) { w.initial_warmth_k += by; };
  if (plant::has_temperature(log.comparison)) out.push_back({0.2, kWarmth_k, warm});
  if (!facts.temperature_known) out.push_back({1.0, kSeason_k, warm});
  if (log.comparison.find("soc") != nullptr) {
    out.push_back({0.002, kCounted, [](plant::World& w, const Start&, double by) { w.reported_soc_low += by; }});
  }
  for (std::size_t gap = 0; gap < facts.gaps.size(); ++gap) {
    out.push_back({0.002, kUnderLoad,
                   [](plant::World& w, const Start& start, double by) {
                     w.soc_after_gap.resize(std::max(w.soc_after_gap.size(), start.gap + 1));
                     w.soc_after_gap[start.gap] += by;
                   },
                   gap, 0, true, true});
    if (!plant::has_temperature(log.comparison)) continue;
    out.push_back({0.2, kWarmth_k,
                   [](plant::World& w, const Start& start, double by) {
                     w.warmth_after_gap.resize(std::max(w.warmth_after_gap.size(), start.gap + 1));
                     w.warmth_after_gap[start.gap] += by;
                   },
                   gap});
  }
  if (log.read.cells_at_rows) {
    out.push_back({0.05, kOfRow * usual_interval_s(log.comparison.log, "current"),
                   [](plant::World& w, const Start&, double by) { w.cells_late_s += by; }});
  }
  if (log.read.cells_apart) {
    out.push_back({0.1, kOfMoved * changed_between_rows(log),
                   [](plant::World& w, const Start&, double by) { w.cells_held += by; }});
  }
  add_branches(log, out);
  if (const double doubt_k = air_doubt_k(log); doubt_k > 0.0) {
    out.push_back(
        {1.0, doubt_k, [](plant::World& w, const Start&, double by) { w.car.environment.ambient_c += by; }});
  }
  return out;
}

std::vector<VectorXd> effect_of_start(const Observed& log, const Start& start) {
  plant::World changed = log.model;
  start.apply(changed, start, start.step);
  std::vector<VectorXd> out = slope(log.effect_of(predicted(log, changed, Acts::kOnBattery)), {}, start.step);
  if (start.is_of_voltage) forget_heat(log, out);
  return out;
}

const std::vector<VectorXd>& known_effect_of_start(const Observed& log, const Start& start, std::size_t number) {
  return known(log, fmt::format("start {}", number), [&] { return effect_of_start(log, start); });
}

}  // namespace

VectorXd bending_starts(const Observed& log, VectorXd starts) {
  const std::vector<Start> kinds = starts_of(log);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (!kinds[k].bends) starts(static_cast<Index>(k)) = 0.0;
  }
  return starts;
}

void take_straight_starts(const Observed& log, const VectorXd& starts, std::vector<VectorXd>& moved) {
  const std::vector<Start> kinds = starts_of(log);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const std::vector<VectorXd>& effect = known_effect_of_start(log, kinds[k], k);
    const double size = starts(static_cast<Index>(k));
    for (std::size_t c = 0; c < moved.size(); ++c) {
      if (effect[c].size() == 0) continue;
      moved[c] = moved[c].size() > 0 ? VectorXd(moved[c] - size * effect[c]) : VectorXd(-size * effect[c]);
    }
  }
}

namespace {

/// Where the log began, how full and how warm beside its thermistors, the air that it does not say, and how full it
/// was after each gap.
void add_starts(const Observed& log, Collected& columns, std::vector<Index>& nuisances) {
  const std::vector<Start> starts = starts_of(log);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    nuisances.push_back(columns.add(known_effect_of_start(log, starts[k], k), starts[k].sigma, 1.0));
  }
}

std::vector<const ReadChannel*> pointers_to(const std::vector<ReadChannel>& channels) {
  std::vector<const ReadChannel*> out;
  for (const ReadChannel& channel : channels) out.push_back(&channel);
  return out;
}

/// Is the voltage that it would act on what a battery unit made up? Of the battery that says nothing.
bool is_made_up(const plant::Cause& cause, const Observed& log) {
  const std::string_view name = cause.name;
  if (!log.comparison.log.published_is_no_measurement || log.channels.front().name != "pack_voltage") return false;
  const bool of_sensor = name.starts_with("voltage_") || name.starts_with("current_") ||
                         name.starts_with("reported_") || name == "time_skew";
  return !of_sensor && (cause.balance == plant::Balance::kVoltage || cause.balance == plant::Balance::kCharge);
}

/// The start is no finding where the log does not say what it was; air that it says is not contradicted. What follows
/// the temperature is told by a log that says it.
bool may_be_named(const plant::Cause& cause, const Observed& log) {
  const std::string_view name = cause.name;
  if (is_made_up(cause, log)) return false;
  if (name == "resistance_temperature" && !log.comparison.facts.temperature_known) return false;
  if (name == "ambient") return says_no_air(log);
  return name != "initial_soc" || log.comparison.find("soc") != nullptr;
}

/// The forms of a cause on this log. A current sensor that ends at a limit has no signature that is a straight
/// line: its column is the whole effect, and where its bends are followed nothing is left to estimate.
std::vector<plant::Form> forms_of(const plant::Cause& cause, const Observed& log) {
  if (std::string_view(cause.name) != "current_saturation") return cause.forms(log.model, log.comparison);
  const std::optional<plant::Rail> rail = plant::rail_of(*log.comparison.log.find("current"));
  if (!rail || log.comparison.facts.at_limit.empty()) return {};
  plant::Form form;
  form.at = {rail->limit_a};
  // The slow part of a sensor's noise does not average out: one reading's spread is the mean's too. Readings that
  // are all alike say where it ends to half a step.
  form.read = {std::max(rail->noise_a, 0.25 * rail->step_a)};
  form.linear = {0};
  form.apply = [from_a = rail->from_a](plant::World& world, plant::Values) { world.current_limit_a = from_a; };
  return {form};
}

}  // namespace

void begin_at(plant::World& world, const Observed& log, const VectorXd& starts) {
  const std::vector<Start> kinds = starts_of(log);
  for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k].apply(world, kinds[k], starts(static_cast<Index>(k)));
}

bool is_same(const Suspect& a, const Suspect& b) {
  return a.cause == b.cause && a.number == b.number && (a.channel == b.channel || !a.form.apply);
}

Family global_family(const Observed& log, const std::vector<plant::Cause>& causes, const Wanted& wanted) {
  Family out;
  Collected columns;
  std::vector<Index> nuisances;
  add_starts(log, columns, nuisances);
  for (std::size_t k = 0; k < causes.size(); ++k) {
    if (!may_be_named(causes[k], log)) continue;
    const std::vector<plant::Form> forms = forms_of(causes[k], log);
    for (std::size_t number = 0; number < forms.size(); ++number) {
      const plant::Form& form = forms[number];
      if (!form.apply) continue;
      Suspect suspect{static_cast<int>(k), form, number, causes[k].name, form.channel, {}};
      suspect.is_law_of_resistance = causes[k].is_law_of_resistance;
      if (!wanted(suspect)) continue;
      bool any = false;
      for (const std::size_t p : form.linear) {
        plant::World world = log.model;
        std::vector<double> values = form.at;
        const bool whole = form.refined.empty();  // no step: the effect is there or not
        const double typical = whole ? kNothing : causes[k].parameters[p].typical;
        values[p] += kStep * typical;
        form.apply(world, values);
        const std::vector<VectorXd>& effect = known(log, fmt::format("{} {} {}", causes[k].name, number, p), [&] {
          return signature(log, world, causes[k].balance, whole ? 1.0 : kStep);
        });
        any = any || acts(effect);
        // A curve may act where the log was not driven by the model, and is once its start has moved.
        if (acts(effect) || form.bend > 0.0) suspect.columns.push_back(columns.add(effect, kWide, typical));
      }
      if (!any || suspect.columns.size() != form.linear.size()) continue;
      columns.put_curve(form, suspect.columns);
      out.suspects.push_back(std::move(suspect));
    }
  }
  const std::vector<const ReadChannel*> channels = pointers_to(log.channels);
  out.problem = problem_of(channels, log, columns, nuisances);
  out.problem.free -= air_doubt_k(log) > 0.0 ? 1 : 0;
  describe(channels, columns, out);
  return out;
}

Family at_values(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family,
                 const SetValues& at) {
  Family out;
  out.suspects = family.suspects;
  plant::World world = log.model;
  for (std::size_t k = 0; k < at.members.size(); ++k) out.suspects[at.members[k]].form.apply(world, at.values[k]);
  const Acts acts = acts_of(log, causes, out, at.members, world);
  const VectorXd starts = bending_starts(log, at.starts);
  plant::World begun = log.model;
  begin_at(begun, log, starts);
  begin_at(world, log, starts);
  const plant::Prediction battery =
      acts == Acts::kOnCar ? predicted(log, begun, Acts::kOnBattery) : plant::Prediction{};
  const plant::LogFacts believed = facts_with(world, log);
  const auto at_start = [&](const plant::World& of, const plant::LogFacts& facts) {
    return acts == Acts::kOnCar ? plant::predict(of, log.comparison, battery, acts)  // which is as it began
                                : plant::predict(of, log.comparison, facts, log.base, acts);
  };
  const std::vector<VectorXd> moved = log.effect_of(at_start(world, believed));
  std::vector<VectorXd> beyond_starts = moved;
  take_straight_starts(log, starts, beyond_starts);
  forget_guessed_heat(log, beyond_starts);
  std::vector<ReadChannel> channels = log.channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (beyond_starts[c].size() > 0) channels[c].residual -= beyond_starts[c];
  }
  Collected columns;
  std::vector<Index> nuisances;
  add_starts(log, columns, nuisances);
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
      begin_at(stepped, log, starts);
      // What does not heat the cells says nothing of how warm they are: least of all where it does not act.
      const bool heats = cause.balance == plant::Balance::kHeat;
      std::vector<VectorXd> effect =
          slope(log.effect_of(at_start(stepped, heats ? facts_with(stepped, log) : believed)), moved, kStep);
      forget_guessed_heat(log, effect);
      suspect.columns.push_back(columns.add(effect, kWide, cause.parameters[p].typical));
    }
    columns.put_curve(suspect.form, suspect.columns);
  }
  out.problem = problem_of(pointers_to(channels), log, columns, nuisances);
  out.problem.most_slow = family.problem.most_slow;
  out.problem.free = family.problem.free;
  describe(pointers_to(channels), columns, out);
  return out;
}

}  // namespace voltlap::explain
