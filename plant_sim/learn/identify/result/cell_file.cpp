// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "learn/identify/result/cell_parameters.hpp"
#include "learn/identify/result/excitation.hpp"
#include "learn/identify/result/law_facts.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> parts;
  for (const double v : values) parts.push_back(fmt::format("{:.6g}", v));
  std::string text = fmt::format("[{}]", fmt::join(parts, ", "));
  // TOML keeps integers and floats apart: a list of both is refused by older readers.
  return text;
}

std::string real(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string file_names(const CellIdentification& identified) {
  std::vector<std::string> names;
  for (const OperatingPoint& point : identified.points) {
    for (const RecordingResult& file : point.result.files)
      names.push_back(std::filesystem::path(file.path).filename().string());
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string section(const std::string& name, const char* unit, const CellParameterMap& map,
                    const std::string& energy_from) {
  std::string out = fmt::format("\n[{}]\n", name);
  if (map.table.empty()) {
    out += fmt::format("value = {}  # {}; identified\n", numbers(map.value), unit);
    if (map.activation_energy_j_per_mol != 0.0) {
      out += fmt::format("activation_energy_j_per_mol = {}  # J/mol; {}\n", real(map.activation_energy_j_per_mol),
                         energy_from);
    }
    if (map.exchange_current_a != 0.0) {
      out += fmt::format("exchange_current_a = {}  # A; identified; its charge transfer is not in the values above\n"
                         "exchange_activation_energy_j_per_mol = {}  # J/mol; as r1\n",
                         real(map.exchange_current_a), real(map.exchange_activation_energy_j_per_mol));
    }
  } else {
    out += fmt::format("table = {}  # {}; identified, [soc][temperature][current], last index fastest\n",
                       numbers(map.table), unit);
  }
  return out;
}

struct TableName {
  const char* name;
  bool is_tau;
  Index column;
};
std::vector<TableName> table_names(Index branches) {
  constexpr std::array kResistances{"r0_ohm", "r1_ohm", "r2_ohm", "r3_ohm", "r4_ohm"};
  constexpr std::array kTaus{"tau1_s", "tau2_s", "tau3_s", "tau4_s"};
  std::vector<TableName> out;
  for (Index k = 0; k <= branches; ++k) out.push_back({kResistances[static_cast<std::size_t>(k)], false, k});
  for (Index k = 0; k < branches; ++k) out.push_back({kTaus[static_cast<std::size_t>(k)], true, k});
  return out;
}

constexpr double kInterval = 1.96;

Json parameters_json(const IdentifyResult& result) {
  const CircuitModel& model = result.model;
  Json out = Json::object();
  Json em = Json::object();
  for (Index node = 0; node < model.em.size(); ++node) {
    const double half = kInterval * result.uncertainty.sigma(node);
    em["soc"].push_back(model.ocv.at(node));
    em["value"].push_back(model.em(node));
    em["ci95_low"].push_back(model.em(node) - half);
    em["ci95_high"].push_back(model.em(node) + half);
    em["excited"].push_back(is_ocv_excited(result, node));
  }
  out["em_v"] = em;
  const std::vector<TableName> names = table_names(model.branches());
  for (std::size_t table = 0; table < names.size(); ++table) {
    Json one = Json::object();
    for (Index node = 0; node < model.grid.size(); ++node) {
      const double value =
          names[table].is_tau ? model.tau(node, names[table].column)
          : names[table].column == 0 ? model.r0_ohm(node, model.capacity_ah)
                                     : model.r(node, names[table].column);
      const Index at = model.em.size() + static_cast<Index>(table) * model.grid.size() + node;
      const double factor = std::exp(std::min(kInterval * result.uncertainty.sigma(at), 20.0));
      one["soc"].push_back(model.grid.at(node));
      one["value"].push_back(value);
      one["ci95_low"].push_back(value / factor);
      one["ci95_high"].push_back(value * factor);
      one["data_share"].push_back(result.uncertainty.data_share(at));
      one["excited"].push_back(is_excited(result, static_cast<Index>(table), node));
    }
    out[names[table].name] = one;
  }
  return out;
}

Json file_json(const RecordingResult& file) {
  Json out = {{"file", file.path},
              {"map", file.map},
              {"rows", file.rows},
              {"duration_s", file.duration_s},
              {"current_hold", name_of(file.hold)},
              {"current_hold_from", file.hold_from},
              {"soc_anchor", file.anchor.soc},
              {"soc_anchor_from", file.anchor.from},
              {"soc_low", file.soc_low},
              {"soc_high", file.soc_high},
              {"rms_v", file.rms_v},
              {"rms_v_from_anchor", file.rms_pulses_v},
              {"repairs", file.repairs}};
  if (file.read_back) {
    out["fit_rms_v"] = file.read_back->fit_rms_v;
    out["rms_v_used_rows"] = file.read_back->used_rms_v;
    out["fit_rms_v_used_rows"] = file.read_back->fit_used_rms_v;
  }
  return out;
}

Json form_json(const CellParameters& cell, const CellBody& body) {
  Json out = {{"name", body.form_text()}, {"origin", name_of(body.form_origin)}, {"source", body.form_source}};
  out["sides_mm"] = body.form ? Json(body.form->sides_mm) : Json();
  out["volume_m3"] = body.form ? Json(body.form->volume_m3()) : Json();
  out["density_kg_per_m3"] = body.form ? Json(cell.mass_kg / body.form->volume_m3()) : Json();
  out["specific_energy_wh_per_kg"] = specific_energy_wh_per_kg(cell);
  return out;
}

}  // namespace

std::string cell_toml(const CellParameters& cell, const CellBody& body, const CellIdentification& identified) {
  const std::string files = file_names(identified);
  std::string out = fmt::format("# Identified by voltlap identify from {}.\n", files);
  for (const std::string& note : identified.reference_point().result.notes) out += "# " + note + "\n";
  const OcvPolynomial polynomial = ocv_polynomial(identified.reference_point().result.model);
  out += fmt::format("name = \"{}\"\n", cell.name);
  out += fmt::format("# {}: {} ({})\n", name_of(body.form_origin), body.form_text(), body.form_source);
  for (const CellFact& fact : cell_facts(cell, body, identified.temperature_told)) {
    out += fmt::format("{} = {}  # {}; {}: {}\n", fact.key, real(fact.value), fact.unit, name_of(fact.origin),
                       fact.source);
  }
  out += "\n[breakpoints]\n";
  out += fmt::format("soc = {}  # 1; reference study, 2016, Table 6.9\n", numbers(cell.soc_breakpoints));
  out += fmt::format("temperature_c = {}  # degC\n", numbers(cell.temperature_breakpoints_c));
  out += fmt::format("current_a = {}  # A\n", numbers(cell.current_breakpoints_a));
  if (cell.kinetic_law) out += "kinetic_law = true  # between the tests by Arrhenius and Butler-Volmer\n";
  out += fmt::format("\n# As a polynomial in SOC, from SOC^0 up: {} V, within {:.1f} mV.\n",
                     numbers(polynomial.coefficients_v), 1e3 * polynomial.error_max_v);
  out += "[ocv]\n";
  out +=
      fmt::format("soc = {}  # 1\nvoltage_v = {}  # V; identified\n", numbers(cell.ocv_soc), numbers(cell.ocv_v));
  if (!cell.ocv_table_v.empty()) {
    out += fmt::format(
        "table = {}  # V; as each test found it, [soc][temperature][current]; the plant uses the curve\n",
        numbers(cell.ocv_table_v));
  }
  const std::vector<LawFact> laws = law_facts(identified.reference_point().result);
  out += section("r0", "ohm", cell.r0_ohm, law_origin(laws, "r0_activation_energy"));
  const std::size_t branches = cell.branch_count();
  for (std::size_t k = 0; k < branches; ++k)
    out += section(fmt::format("r{}", k + 1), "ohm", cell.branches[k].r_ohm,
                   law_origin(laws, fmt::format("r{}_activation_energy", k + 1)));
  for (std::size_t k = 0; k < branches; ++k)
    out += section(fmt::format("tau{}", k + 1), "s", cell.branches[k].tau_s,
                   law_origin(laws, fmt::format("tau{}_activation_energy", k + 1)));
  const CellEffects& effects = cell.effects;
  if (effects.entropy_v_per_k != 0.0 || effects.hysteresis_v != 0.0) out += "\n[effects]\n";
  if (effects.entropy_v_per_k != 0.0) {
    out += fmt::format("entropy_v_per_k = {}  # V/K, dOCV/dT; {}\n", real(effects.entropy_v_per_k),
                       law_origin(laws, "entropy"));
  }
  if (effects.hysteresis_v != 0.0) {
    out += fmt::format("hysteresis_v = {}  # V, either way of the OCV; {}\nhysteresis_per_soc = {}  # 1, chosen\n",
                       real(effects.hysteresis_v), law_origin(laws, "hysteresis"), real(effects.hysteresis_per_soc));
  }
  return out;
}

std::string identification_json(const CellParameters& cell, const CellBody& body,
                                const CellIdentification& identified, const std::string& version) {
  const Capacity& capacity = identified.reference_point().result.capacity;
  Json out = {{"name", cell.name},
              {"version", version},
              {"capacity_ah", cell.capacity_ah},
              {"capacity_from", name_of(capacity.from)},
              {"capacity_ci95_ah", capacity.ci95_ah ? Json(*capacity.ci95_ah) : Json()},
              {"temperatures_c", identified.temperatures_c},
              {"currents_a", identified.currents_a}};
  const OcvPolynomial polynomial = ocv_polynomial(identified.reference_point().result.model);
  out["ocv_polynomial_v"] = polynomial.coefficients_v;
  out["ocv_polynomial_error_max_v"] = polynomial.error_max_v;
  out["form"] = form_json(cell, body);
  for (const CellFact& fact : cell_facts(cell, body, identified.temperature_told)) {
    out["facts"].push_back({{"key", fact.key},
                            {"value", fact.value},
                            {"unit", fact.unit},
                            {"origin", name_of(fact.origin)},
                            {"source", fact.source}});
  }
  for (const OperatingPoint& point : identified.points) {
    const IdentifyResult& r = point.result;
    Json one = {{"temperature_c", point.temperature_c}, {"current_a", point.current_a},
                {"branches", r.model.branches()},       {"rms_v", r.rms_v},
                {"noise_v2_s", r.noise_v2_s},           {"smoothness_from", r.smoothness_from},
                {"smoothness", r.smoothness > 0.0 ? Json(r.smoothness) : Json()},
                {"iterations", r.iterations},           {"seconds", r.seconds},
                {"hysteresis_v", r.hysteresis_v},       {"notes", r.notes}};
    one["rms_other_blocks_v"] = r.rms_other_blocks_v ? Json(*r.rms_other_blocks_v) : Json(nullptr);
    for (const RecordingResult& file : r.files) one["files"].push_back(file_json(file));
    for (const OrderScore& order : r.orders) {
      one["orders"].push_back({{"branches", order.branches},
                               {"heldout_rms_v", order.heldout_rms_v},
                               {"information_criterion", order.information_criterion}});
    }
    for (const auto& [smoothness, rms] : r.smoothness_scores)
      one["smoothness_scores"].push_back({{"smoothness", smoothness}, {"heldout_rms_v", rms}});
    one["parameters"] = parameters_json(r);
    one["laws"] = Json::array();
    for (const LawFact& law : law_facts(r)) {
      one["laws"].push_back({{"key", law.key},
                             {"value", law.value},
                             {"ci95_low", law.ci95_low},
                             {"ci95_high", law.ci95_high},
                             {"unit", law.unit},
                             {"origin", name_of(law.origin)},
                             {"at_bound", law.at_bound}});
    }
    out["tests"].push_back(one);
  }
  for (std::size_t t = 0; t < identified.temperatures_c.size(); ++t) {
    for (std::size_t i = 0; i < identified.currents_a.size(); ++i) {
      if (!identified.was_tested(t, i)) {
        out["filled"].push_back({{"temperature_c", identified.temperatures_c[t]},
                                 {"current_a", identified.currents_a[i]},
                                 {"from_temperature_c", identified.at(t, i).temperature_c},
                                 {"from_current_a", identified.at(t, i).current_a}});
      }
    }
  }
  return out.dump(2) + "\n";
}

}  // namespace voltlap::plant
