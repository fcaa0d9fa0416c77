// SPDX-License-Identifier: Apache-2.0
#include "io/logs/battery_pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "io/logs/battery_contender.hpp"

namespace voltlap::plant {
namespace {

constexpr double kAnswers = 0.6;      // correlation of the steps from which a voltage answers to a current
constexpr double kBeats = 1.5;        // times as much of the voltage's steps is left unexplained by the other
constexpr double kSilentShare = 0.5;  // of the clearest correlation: below it a voltage does not answer
constexpr std::size_t kSteps = 30;    // large steps from which behaviour says something

std::size_t lag_of(const Contender& contender) {
  return contender.answer.best_lag();
}

class PairChooser {
 public:
  PairChooser(const RecordedSignals& recording, const std::vector<SignalCandidate>& all)
      : recording_(recording), blocks_(recording) {
    for (const SignalCandidate& candidate : all) {
      contend(candidate, Quantity::kCurrent, Meaning::kCurrent, currents_);
      contend(candidate, Quantity::kVoltage, Meaning::kVoltage, voltages_);
    }
    for (Contender& current : currents_) find_voltage(current);
    std::stable_sort(currents_.begin(), currents_.end(), [](const Contender& a, const Contender& b) {
      if (a.standing != b.standing) return a.standing > b.standing;
      return std::abs(a.answer.clearest()) > std::abs(b.answer.clearest());
    });
  }

  BatteryPair choose() {
    const Contender* current = chosen_current();
    if (current == nullptr) return std::move(out_);
    const Contender* voltage = chosen_voltage(*current);
    if (voltage == nullptr) return std::move(out_);
    put(*current, *voltage);
    return std::move(out_);
  }

 private:
  void contend(const SignalCandidate& candidate, Quantity quantity, Meaning meaning, std::vector<Contender>& into) {
    const Standing standing = standing_of(candidate, quantity, meaning, recording_.is_can);
    // Without a word behaviour must tell; what stands still has none.
    const bool silent = standing == Standing::kUnnamed;
    if (standing == Standing::kExcluded || (silent && !candidate.varies())) return;
    if (silent && is_like_a_voltage(candidate) != (quantity == Quantity::kVoltage)) return;
    into.push_back({&candidate, standing, blocks_.of(*candidate.signal), nullptr, {}});
  }

  void find_voltage(Contender& current) const {
    for (const Contender& voltage : voltages_) {
      if (voltage.candidate == current.candidate || voltage.standing < Standing::kUnnamed) continue;
      const VoltageAnswer answer = voltage_answer(current.means, voltage.means);
      if (current.voltage != nullptr && std::abs(answer.clearest()) <= std::abs(current.answer.clearest()))
        continue;
      current.voltage = &voltage;
      current.answer = answer;
    }
  }

  /// Whether one explains the voltage so much better than the other that no sensor's noise can be why.
  [[nodiscard]] bool beats(const Contender& a, const Contender& b) const {
    if (a.voltage == nullptr || a.answer.steps < kSteps || std::abs(a.answer.clearest()) < kAnswers) return false;
    const VoltageAnswer other = voltage_answer(b.means, a.voltage->means);
    return kBeats * a.answer.rest(lag_of(a)) <= other.rest(lag_of(a));
  }
  /// b is the product of a and a's voltage rather than a itself: a power, not a current.
  [[nodiscard]] static bool is_power(const Contender& b, const Contender& a);
  [[nodiscard]] static bool is_beside(const Contender& b, const Contender& a);

  [[nodiscard]] const Contender* chosen_current();
  [[nodiscard]] const Contender* among_unnamed();
  [[nodiscard]] const Contender* chosen_voltage(const Contender& current);
  [[nodiscard]] std::vector<const Contender*> named_voltages() const;
  [[nodiscard]] const Contender* best_answer(const std::vector<const Contender*>& group,
                                             const Contender& current) const;
  void ask(const std::string& role, const std::string& why, std::vector<const Contender*> candidates);
  [[nodiscard]] ProposedRole proposed(const std::string& role, const Contender& contender, const std::string& unit,
                                      const std::string& evidence) const;
  [[nodiscard]] std::vector<std::string> current_units(const Contender& current, const Contender& voltage,
                                                       const VoltageAnswer& answer) const;
  [[nodiscard]] static std::string evidence_of(const Contender& current, const Contender& voltage,
                                               const VoltageAnswer* answer, double amperes);
  void put(const Contender& current, const Contender& voltage);
  void put_bus_voltage(const Contender& voltage);

  const RecordedSignals& recording_;
  BlockMeans blocks_;
  std::vector<Contender> currents_, voltages_;
  BatteryPair out_;
};

bool PairChooser::is_power(const Contender& b, const Contender& a) {
  constexpr double kTighter = 0.5;
  if (a.voltage == nullptr) return false;
  const LineFit product = line_fit(b.means, a.means, &a.voltage->means),
                plain = line_fit(b.means, a.means, nullptr);
  return product.count >= kSteps && product.rest < kTighter * plain.rest && is_beside(b, a);
}

/// Both run so close to each other that noise decides to which of them a voltage answers more.
bool PairChooser::is_beside(const Contender& b, const Contender& a) {
  constexpr double kClose = 0.05;
  return line_fit(b.means, a.means, nullptr).rest < kClose;
}

void PairChooser::ask(const std::string& role, const std::string& why, std::vector<const Contender*> candidates) {
  constexpr std::size_t kShown = 6;
  if (candidates.size() > kShown) candidates.resize(kShown);
  OpenChoice choice{role, why, {}};
  for (const Contender* contender : candidates) {
    const bool amperes = role == "current";
    const std::string unit = amperes ? "A" : contender->candidate->voltage_unit();
    const std::string evidence =
        amperes && contender->voltage != nullptr
            ? fmt::format("{} answers with correlation {:.2f}", contender->voltage->candidate->signal->described(),
                          contender->answer.clearest())
            : contender->candidate->signal->described();
    choice.candidates.push_back(proposed(role, *contender, unit, evidence));
  }
  out_.open.push_back(std::move(choice));
}

ProposedRole PairChooser::proposed(const std::string& role, const Contender& contender, const std::string& unit,
                                   const std::string& evidence) const {
  const RecordedSignal& signal = *contender.candidate->signal;
  return {role, source_in(signal, unit), signal.described(), evidence};
}

const Contender* PairChooser::chosen_current() {
  std::vector<const Contender*> group, rest;
  if (currents_.empty()) {
    ask("current", "no signal is one", {});
    ask("voltage", "it needs the current first", {});
    return nullptr;
  }
  const Standing best = currents_.front().standing;
  if (best <= Standing::kUnnamed) return among_unnamed();
  // A symbol says little: i of a, b, c with units is no more than its unit.
  const bool by_letter = std::all_of(currents_.begin(), currents_.end(), [&](const Contender& c) {
    return c.standing != best || c.candidate->name.is_letter;
  });
  const Standing least = by_letter ? std::min(best, Standing::kByUnit) : best;
  for (const Contender& current : currents_) (current.standing >= least ? group : rest).push_back(&current);
  const Contender* chosen = group.front();
  for (const Contender* other : group) {
    if (other == chosen || is_same(*other, *chosen)) continue;
    if (beats(*chosen, *other) && !is_beside(*other, *chosen)) continue;
    ask("current", "several could be it", group);
    return nullptr;
  }
  for (const Contender* rival : rest) {
    const bool actual = rival->standing >= Standing::kUnnamed;
    if (!actual || is_same_course(rival->means, chosen->means) || !beats(*rival, *chosen)) continue;
    if (rival->standing == Standing::kUnnamed && is_power(*rival, *chosen)) continue;
    ask("current", "the name says one and the voltage answers to another", {chosen, rival});
    return nullptr;
  }
  return chosen;
}

const Contender* PairChooser::among_unnamed() {
  std::vector<const Contender*> all;
  for (const Contender& current : currents_) all.push_back(&current);
  std::stable_sort(all.begin(), all.end(), [](const Contender* a, const Contender* b) {
    return std::abs(a->answer.clearest()) > std::abs(b->answer.clearest());
  });
  for (const Contender* one : all) {
    if (one->standing != Standing::kUnnamed || one->voltage == nullptr || one->answer.steps < kSteps) continue;
    const bool best = std::abs(one->answer.clearest()) >= kAnswers &&
                      std::all_of(all.begin(), all.end(), [&](const Contender* other) {
                        if (other == one || is_power(*other, *one)) return true;
                        return !is_beside(*other, *one) && beats(*one, *other);
                      });
    if (best) return one;
  }
  ask("current", "no name tells it and no voltage answers to one signal clearly more than to all others", all);
  return nullptr;
}

/// Measured voltages of the battery by name, those of the pack before those that do not say whose they are.
std::vector<const Contender*> PairChooser::named_voltages() const {
  std::vector<const Contender*> all, pack, nobody, cell, bus;
  for (const Contender& voltage : voltages_) {
    if (voltage.standing < Standing::kByUnit) continue;
    const Owner owner = voltage.candidate->name.owner;
    if (owner == Owner::kPack) pack.push_back(&voltage);
    if (owner == Owner::kNobody) nobody.push_back(&voltage);
    if (owner == Owner::kCell) cell.push_back(&voltage);
    if (owner == Owner::kBus) bus.push_back(&voltage);
  }
  for (const auto* group : {&pack, &nobody, &cell, &bus}) {
    Standing best = Standing::kByUnit;
    for (const Contender* voltage : *group) best = std::max(best, voltage->standing);
    const bool by_letter = std::all_of(group->begin(), group->end(), [&](const Contender* v) {
      return v->standing != best || v->candidate->name.is_letter;
    });
    for (const Contender* voltage : *group) {
      if (voltage->standing == best || by_letter) all.push_back(voltage);
    }
    if (!all.empty()) break;
  }
  return all;
}

/// The one that answers clearly more than the others, or the only one; nullptr where that cannot be told.
const Contender* PairChooser::best_answer(const std::vector<const Contender*>& group,
                                          const Contender& current) const {
  const Contender* best = nullptr;
  VoltageAnswer clearest;
  for (const Contender* voltage : group) {
    const VoltageAnswer answer = voltage_answer(current.means, voltage->means);
    if (best != nullptr && std::abs(answer.clearest()) <= std::abs(clearest.clearest())) continue;
    best = voltage;
    clearest = answer;
  }
  for (const Contender* voltage : group) {
    const bool named = voltage->standing >= Standing::kWorded && best->standing >= Standing::kWorded;
    if (voltage == best || is_same(*voltage, *best) || are_cells_alike(*voltage, *best) ||
        (named && is_same_level(*voltage, *best)))
      continue;
    const VoltageAnswer answer = voltage_answer(current.means, voltage->means);
    const bool clear = std::abs(clearest.clearest()) >= kAnswers &&
                       std::abs(answer.clearest()) < kSilentShare * std::abs(clearest.clearest());
    if (!clear) return nullptr;
  }
  return best;
}

const Contender* PairChooser::chosen_voltage(const Contender& current) {
  constexpr double kOpposite = 0.2;
  std::vector<const Contender*> group = named_voltages(), answering;
  for (const Contender& voltage : voltages_) {
    const bool usable = voltage.candidate != current.candidate && voltage.standing >= Standing::kUnnamed;
    const VoltageAnswer answer = voltage_answer(current.means, voltage.means);
    if (usable && answer.steps >= kSteps && std::abs(answer.clearest()) >= kAnswers) answering.push_back(&voltage);
  }
  const bool named = !group.empty();
  if (!named) group = answering;
  const Contender* chosen = group.empty() ? nullptr : best_answer(group, current);
  if (chosen == nullptr) {
    for (const Contender& voltage : voltages_) {
      if (group.empty()) answering.push_back(&voltage);
    }
    out_.roles.push_back(proposed("current", current, "A", "by its name"));
    const bool told = current.candidate->signal->unit || recording_.is_can;
    if (!told || current.standing == Standing::kUnnamed) {
      out_.roles.pop_back();
      ask("current", "the voltage must be known first", {&current});
    }
    ask("voltage", group.empty() ? "no signal is one" : "several could be it", group.empty() ? answering : group);
    return nullptr;
  }
  if (!named || answering.empty()) return chosen;
  const double own = voltage_answer(current.means, chosen->means).clearest();
  const Contender* other = best_answer(answering, current);
  if (other == nullptr || other == chosen || other->standing < Standing::kByUnit) return chosen;
  const double its = voltage_answer(current.means, other->means).clearest();
  const bool contradicted =
      std::abs(own) < kSilentShare * std::abs(its) || (own * its < 0.0 && std::abs(own) > kOpposite);
  return contradicted ? other : chosen;
}

/// Units of the current with which each cell has the resistance of one: a cell of hundreds of Ah has 0.1 mOhm, a
/// small one in the cold 1 Ohm.
std::vector<std::string> PairChooser::current_units(const Contender& current, const Contender& voltage,
                                                    const VoltageAnswer& answer) const {
  constexpr double kUsualCell = 3.6, kLeast = 0.08e-3, kMost = 0.3, kMostTold = 3.0, kMostAmpere = 2000.0;
  const double volts = voltage.candidate->volts(voltage.candidate->middle());
  const double cells = std::max(1.0, std::round(volts / kUsualCell));
  const double in_volts = voltage.candidate->volts(1.0) - voltage.candidate->volts(0.0);
  const double ohm =
      std::abs(answer.slope[answer.best_lag()]) * in_volts / cells;  // of a cell, by recorded amperes
  const double largest = std::max(std::abs(current.candidate->low()), std::abs(current.candidate->high()));
  const auto& told = current.candidate->signal->unit;
  std::vector<std::string> out;
  if (told) {
    const double real = ohm / told->scale;
    if (real > 0.25 * kLeast && real < kMostTold) out.emplace_back(told->name);
    return out;
  }
  for (const auto& [unit, scale] : {std::pair{"A", 1.0}, {"mA", 1e-3}}) {
    if (ohm / scale > kLeast && ohm / scale < kMost && largest * scale < kMostAmpere) out.emplace_back(unit);
  }
  return out;
}

/// `answer`: nullptr where the voltage does not show it.
std::string PairChooser::evidence_of(const Contender& current, const Contender& voltage, const VoltageAnswer* answer,
                                     double amperes) {
  const std::string named = current.standing == Standing::kUnnamed ? "" : "by its name and unit, ";
  if (answer == nullptr) return named + "no steps that would show it";
  const SignalCandidate& answering = *voltage.candidate;
  const double ohm =
      std::abs(answer->slope[answer->best_lag()]) * (answering.volts(1.0) - answering.volts(0.0)) / amperes;
  return fmt::format("{}{} answers to it with {:.3g} mOhm, correlation {:.2f} over {} steps", named,
                     answering.signal->described(), 1e3 * ohm, answer->clearest(), answer->steps);
}

void PairChooser::put(const Contender& current, const Contender& voltage) {
  constexpr double kSign = 0.7;
  const VoltageAnswer answer = voltage_answer(current.means, voltage.means);
  const double r = answer.clearest();
  const bool clear = answer.steps >= kSteps && std::abs(r) >= kAnswers;
  const auto& told = current.candidate->signal->unit;
  std::vector<std::string> units;
  if (told) units = {std::string(told->name)};
  if (recording_.is_can && !told) units = {"A"};  // a DBC scales to amperes where it names no unit
  if (clear) units = current_units(current, voltage, answer);
  // Without behaviour the name must leave nothing open, on a bus not even whose current it is.
  const bool name_is_enough = current.standing == Standing::kPlain &&
                              (!recording_.is_can || current.candidate->name.owner == Owner::kPack ||
                               current.candidate->name.owner == Owner::kCell);
  if (!clear && !name_is_enough) {
    ask("current", "its name alone does not tell it, and no voltage answers to it in this recording", {&current});
    ask("voltage", "it needs the current first", {&voltage});
    return;
  }
  if (units.size() != 1) {
    const bool impossible = units.empty() && (told || clear);
    ask("current", impossible ? "a battery of such a resistance there is not" : "its unit is not told", {&current});
    if (!told) out_.open.back().candidates.push_back(proposed("current", current, "mA", "in mA"));
    return;
  }
  ProposedRole role = proposed("current", current, told ? "" : units.front(), "");
  role.evidence = evidence_of(current, voltage, clear ? &answer : nullptr, role.source.scale);
  if (clear && std::abs(r) >= kSign)
    role.source.discharge = r < 0.0 ? DischargeSign::kPositive : DischargeSign::kNegative;
  const bool of_cell = voltage.candidate->is_cell_voltage();
  const std::string unit = voltage.candidate->voltage_unit();
  if (unit.empty() && !voltage.candidate->signal->unit) {
    ask("voltage", "its unit is not told", {&voltage});
    return;
  }
  out_.roles.push_back(role);
  out_.roles.push_back(proposed(of_cell ? "voltage" : "pack_voltage", voltage, unit,
                                voltage.standing == Standing::kUnnamed ? "answers to the current"
                                : clear ? "by its name and unit, answers to the current"
                                        : "by its name and unit"));
  out_.current = current.candidate->signal;
  out_.voltage = voltage.candidate->signal;
  out_.is_clear = clear;
  out_.taken = {out_.current, out_.voltage};
  put_bus_voltage(voltage);
}

/// On the car's side of the contactors; nothing depends on it.
void PairChooser::put_bus_voltage(const Contender& chosen) {
  std::vector<const Contender*> buses;
  for (const Contender& voltage : voltages_) {
    const bool is_bus = voltage.candidate->name.owner == Owner::kBus && voltage.candidate->name.is_actual;
    if (is_bus && &voltage != &chosen && !voltage.candidate->is_cell_voltage()) buses.push_back(&voltage);
  }
  if (buses.size() != 1 || !buses.front()->candidate->signal->unit) return;
  out_.roles.push_back(proposed("bus_voltage", *buses.front(), "", "by its name"));
  out_.taken.push_back(buses.front()->candidate->signal);
}

}  // namespace

BatteryPair choose_battery_pair(const RecordedSignals& recording, const std::vector<SignalCandidate>& all) {
  BatteryPair out = PairChooser(recording, all).choose();
  VOLTLAP_DEMAND(!out.open.empty() || (out.current != nullptr && out.voltage != nullptr));
  return out;
}

}  // namespace voltlap::plant
