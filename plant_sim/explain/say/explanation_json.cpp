// SPDX-License-Identifier: Apache-2.0
#include "explain/say/explanation_json.hpp"

#include <nlohmann/json.hpp>

#include "explain/say/page/race_rows.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

Json parameter_json(const FoundParameter& p) {
  if (p.unit == "name") return {{"value", p.text}, {"ci95_low", p.text}, {"ci95_high", p.text}, {"unit", "name"}};
  if (p.unit == "index") {
    const int index = static_cast<int>(p.value);
    return {{"value", index}, {"ci95_low", index}, {"ci95_high", index}, {"unit", "index"}};
  }
  return {{"value", p.value}, {"ci95_low", p.low}, {"ci95_high", p.high}, {"unit", p.unit}};
}

Json cause_json(const FoundCause& cause) {
  Json parameters = Json::object();
  for (const FoundParameter& p : cause.parameters) parameters[p.name] = parameter_json(p);
  return {{"name", cause.name},
          {"parameters", parameters},
          {"share_of_residual", cause.share_of_residual},
          {"probability", cause.probability},
          {"d_prime", cause.d_prime},
          {"equivalent_to", cause.equivalent_to}};
}

}  // namespace

std::string explanation_json(const Explanation& e, const RaceChange* race, std::uint64_t seed,
                             const std::string& version, const std::string& extended_model) {
  Json out = {{"verdict", name_of(e.verdict)}, {"sentence", e.sentence}, {"causes", Json::array()}};
  for (const FoundCause& cause : e.causes) out["causes"].push_back(cause_json(cause));
  if (e.verdict == Verdict::kAmbiguous) out["alternatives"] = e.alternatives;
  out["unknown_in"] = e.unknown_in ? Json(name_of(*e.unknown_in)) : Json();
  out["gain"] = Json::object();
  for (const auto& [channel, gain] : e.gain) {
    out["gain"][channel] = {
        {"heldout_rms_before", gain.before}, {"heldout_rms_after", gain.after}, {"noise_floor", gain.floor}};
  }
  out["masked"] = Json::array();
  for (const Masked& m : e.masked) {
    out["masked"].push_back(
        {{"channel", m.channel}, {"start_s", m.start_s}, {"end_s", m.end_s}, {"reason", m.reason}});
  }
  out["next_test"] = e.next_test.empty() ? Json() : Json(e.next_test);
  out["extended_model"] = extended_model.empty() ? Json() : Json(extended_model);
  out["prediction"] = Json::parse(race_json(race));
  out["mode"] = e.with_references ? "reference" : "absolute";
  out["seed"] = seed;
  out["version"] = version;
  // A file name need not be UTF-8, JSON must.
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace voltlap::plant
