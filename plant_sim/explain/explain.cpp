// SPDX-License-Identifier: Apache-2.0
#include "explain/explain.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "discrepancy/car_balances.hpp"
#include "discrepancy/causes/list.hpp"
#include "discrepancy/integrity.hpp"
#include "explain/decide/answer.hpp"
#include "explain/decide/unknown.hpp"
#include "explain/model/corrected.hpp"
#include "explain/model/interpolated.hpp"
#include "explain/say/explanation.hpp"

namespace voltlap::explain {
namespace {

/// A log against the model, with everything that is asked of it.
struct Held {
  plant::Recording log;
  plant::World world;
  Observed seen;
  std::vector<Family> members;
  std::unique_ptr<Family> global;
};

Held held_against(const plant::World& model, plant::Recording read, const plant::ComparisonOptions& compared) {
  Held out;
  out.world = model;
  out.log = interpolated(model, std::move(read));
  plant::Comparison comparison = plant::comparison_of(model, out.log, compared);
  if (out.log.derived.contains("motor_speed")) {
    // As the car's speed is, and the slip that its tyres have by the model.
    out.log.signals["motor_speed"] = plant::car_prediction("motor_speed", model, comparison, {});
    comparison = plant::comparison_of(model, out.log, compared);
  }
  out.seen = observed(model, std::move(comparison), compared.hold.has_value());
  return out;
}

void learn_members(Held& held, const std::vector<plant::Cause>& causes) {
  for (const Member& member : held.seen.members) held.members.push_back(member_family(held.seen, member, causes));
}

/// The same member's family in each reference.
std::vector<const Family*> same_member(const std::vector<Held>& references, const std::string& role) {
  std::vector<const Family*> out;
  for (const Held& reference : references) {
    for (std::size_t k = 0; k < reference.members.size(); ++k) {
      if (reference.seen.members[k].channel.name == role) out.push_back(&reference.members[k]);
    }
  }
  return out;
}

std::vector<AnswerOf> member_answers(const Held& held, const std::vector<Held>& references,
                                     const std::vector<plant::Cause>& causes) {
  std::vector<AnswerOf> out;
  for (std::size_t k = 0; k < held.members.size(); ++k) {
    const Member& member = held.seen.members[k];
    const auto alike = std::count_if(held.seen.members.begin(), held.seen.members.end(),
                                     [&](const Member& other) { return other.group == member.group; });
    Search search(held.members[k], causes);
    AnswerOf answer = answer_of(held.members[k], search,
                                {same_member(references, member.channel.name), static_cast<double>(alike)},
                                [](const Family&, const Set& set) { return set; });
    if (!answer.sets.empty()) out.push_back(std::move(answer));
  }
  return out;
}

/// Does this answer say how warm a cell is that another answer names? A cell that is weak or leaks warms its
/// thermistor: where every cell has one, that of its number.
bool follows_from_cell(const Held& held, const AnswerOf& answer, const std::vector<AnswerOf>& answers) {
  const std::string& role = answer.family->channel.front();
  const auto thermistors = held.log.numbered("temperature_");
  if (!role.starts_with("temperature_") || thermistors.size() != held.log.numbered("cell_voltage_").size())
    return false;
  const std::string cell = "cell_voltage_" + role.substr(role.find_last_of('_') + 1);
  return std::any_of(answers.begin(), answers.end(), [&](const AnswerOf& other) {
    const Set& set = other.sets.front();
    return other.family->channel.front() == cell &&
           std::any_of(set.members.begin(), set.members.end(),
                       [&](std::size_t m) { return !other.family->suspects[m].form.of_sensor; });
  });
}

/// What the first set of each answer puts into its member's readings.
std::vector<MemberEffect> effects_of(const Held& held, const std::vector<AnswerOf>& answers) {
  std::vector<MemberEffect> out;
  for (const AnswerOf& answer : answers) {
    const Set& set = answer.sets.front();
    for (std::size_t m = 0; m < set.members.size(); ++m) {
      const Suspect& c = answer.family->suspects[set.members[m]];
      const std::vector<VectorXd> shapes = c.form.shapes(held.world, held.seen.comparison, held.seen.base);
      MemberEffect effect{c.channel, c.form.of_sensor || c.channel.starts_with("temperature_"),
                          VectorXd::Zero(held.log.rows())};
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        effect.by_row +=
            set.values[m][c.form.linear[s]] * VectorXd(shapes[s].array().isFinite().select(shapes[s], 0.0));
      }
      out.push_back(std::move(effect));
    }
  }
  return out;
}

AnswerOf global_answer(const Held& held, const std::vector<Held>& references,
                       const std::vector<plant::Cause>& causes) {
  std::vector<const Family*> theirs;
  for (const Held& reference : references) theirs.push_back(reference.global.get());
  Search search(*held.global, causes);
  const Fit& nothing = search.nothing();
  return answer_of(*held.global, search, {theirs, 1.0}, [&](const Family& family, const Set& set) {
    return refined(held.seen, causes, family, nothing, set);
  });
}

/// What the gate found and sound logs do not have. Steps of a pedal, and steps that no reading is worse for, are no
/// finding.
std::vector<plant::FoundCause> unusual(const std::vector<plant::GateFinding>& findings,
                                       const std::vector<std::vector<plant::GateFinding>>& usual) {
  std::vector<plant::GateFinding> worth;
  std::copy_if(findings.begin(), findings.end(), std::back_inserter(worth),
               [](const plant::GateFinding& f) { return f.cause != "quantisation" || f.worth_telling; });
  return plant::unusual_findings(worth, usual);
}

/// Shapes without a name that sound logs do not have.
std::optional<Unnamed> unnamed_of(const Held& held, const std::vector<VectorXd>& left,
                                  const std::vector<Held>& references) {
  constexpr double kBeyond = 2.0;                       // of what references have
  const double least = references.empty() ? 2.0 : 1.0;  // practical sizes: alone, a model's own error is not known
  std::optional<Unnamed> out;
  std::vector<std::vector<Unnamed>> theirs;
  for (const Unnamed& one : unnamed_in(held.seen, left)) {
    if (!one.lead.decisive || one.practical < least) continue;
    // How well tyres and brakes are known is told by sound drives alone.
    if (references.empty() && one.balance == plant::Balance::kForce) continue;
    if (theirs.empty()) {
      for (const Held& reference : references)
        theirs.push_back(unnamed_in(reference.seen, residuals_of(reference.seen)));
    }
    double usual = 0.0;
    for (const auto& reference : theirs) {
      for (const Unnamed& same : reference) {
        if (same.channel == one.channel) usual = std::max(usual, same.practical);
      }
    }
    if (one.practical > least + kBeyond * usual && (!out || one.practical > out->practical)) out = one;
  }
  return out;
}

}  // namespace

plant::Explanation explain(const plant::Model& model, const plant::Recording& raw,
                           const plant::ExplainOptions& options) {
  const auto progress = [&](const char* what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  plant::ComparisonOptions compared{model.kind != plant::ModelKind::kCell, !options.references.empty()};
  std::vector<plant::Cause> causes = plant::catalogue(options.without);
  plant::size_for(model.world.car.cell, causes);
  plant::Gated gated = plant::integrity_gate(raw, model, false);
  std::vector<Held> references;
  std::vector<std::vector<plant::GateFinding>> usual_findings;
  for (const plant::Recording& reference : options.references) {
    progress("reading references",
             0.1 + 0.4 * static_cast<double>(references.size()) / static_cast<double>(options.references.size()));
    plant::Gated theirs = plant::integrity_gate(reference, model, false);
    usual_findings.push_back(theirs.findings);
    references.push_back(held_against(model.world, std::move(theirs.log), compared));
    compared.hold = references.front().seen.comparison.facts.hold;  // one logger holds the current in one way
    learn_members(references.back(), causes);
    references.back().global = std::make_unique<Family>(global_family(references.back().seen, causes));
  }
  Saying saying{model, causes, {}, {}, {}, {}, {}, {}};
  saying.with_references = !references.empty();
  saying.gate = unusual(gated.findings, usual_findings);
  if (!gated.enough.empty()) return too_little(saying, gated);
  progress("comparing with the model", 0.5);
  Held held = held_against(model.world, gated.log, compared);
  learn_members(held, causes);
  saying.members = member_answers(held, references, causes);
  progress("weighing causes", 0.6);
  Held rest = held_against(model.world, corrected(held.log, effects_of(held, saying.members)), compared);
  const std::vector<AnswerOf> all = saying.members;
  std::erase_if(saying.members, [&](const AnswerOf& answer) { return follows_from_cell(held, answer, all); });
  rest.global = std::make_unique<Family>(global_family(rest.seen, causes));
  saying.global = global_answer(rest, references, causes);
  progress("looking for what has no name", 0.85);
  saying.left = left_by(rest.seen, saying.global, causes);
  saying.unnamed = unnamed_of(rest, saying.left, references);
  return said(saying, gated, held.seen, rest.seen);
}

}  // namespace voltlap::explain
