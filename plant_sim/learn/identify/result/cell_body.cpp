// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/number_text.hpp"

namespace voltlap::plant {
namespace {

/// Of the cells in data/cells: the round ones have 2670 to 2810 kg/m3, the pouch 2240.
constexpr double kCylinderDensity_kg_per_m3 = 2700.0, kBoxDensity_kg_per_m3 = 2200.0;

double density(const CellForm& form) { return form.is_cylinder() ? kCylinderDensity_kg_per_m3 : kBoxDensity_kg_per_m3; }

double usual_mass_kg(const CellForm& form) { return density(form) * form.volume_m3(); }

/// The named cylinder that a cell of this mass or, without one, of this capacity mostly is; null where it is none.
const CellForm* usual_cylinder(std::optional<double> mass_kg, const Capacity& capacity) {
  constexpr double kLeast_ah = 1.0, k18650Most_ah = 3.6, kMost_ah = 6.0, kAlike = 1.15;
  const std::vector<CellForm>& cylinders = named_cylinders();
  // A part of a discharge says that the cell is no larger kind, not that it is as small as that.
  if (capacity.ah > kMost_ah || (capacity.ah < kLeast_ah && !capacity.is_lower_bound())) return nullptr;
  if (!mass_kg) return capacity.ah <= k18650Most_ah ? &cylinders[0] : &cylinders[1];
  const auto fits = [&](const CellForm& form) {
    return std::abs(std::log(*mass_kg / usual_mass_kg(form))) < std::log(kAlike);
  };
  const auto found = std::find_if(cylinders.begin(), cylinders.end(), fits);
  return found == cylinders.end() ? nullptr : &*found;
}

/// The shipped cell whose thermal numbers stand for the form: a round one, or the pouch whose size is nearer.
const char* model_of(const std::optional<CellForm>& form, double capacity_ah) {
  constexpr double kBetweenThePouches_ah = 19.0;  // geometric mean of 6.6 and 55.2 Ah
  if (form && form->is_cylinder()) return "molicel_p42a";
  return capacity_ah < kBetweenThePouches_ah ? "melasta_slpbb042126" : "aesc_e5_2p";
}

void settle_form(const ToldBody& told, const Capacity& capacity, CellBody& body) {
  const std::string ah = (capacity.is_lower_bound() ? "at least " : "") + significant(capacity.ah, 3) + " Ah";
  const std::string why = told.mass_kg ? fmt::format("{} and {:g} kg", ah, *told.mass_kg) : ah;
  body.form = told.form;
  if (told.form) {
    body.form_origin = FactOrigin::kTold;
    body.form_source = "--size";
  } else if (const CellForm* cylinder = usual_cylinder(told.mass_kg, capacity)) {
    body.form = *cylinder;
    body.form_source = fmt::format("a cell of {} is mostly a {}", why, cylinder->name);
  } else {
    body.form_source = fmt::format("a cell of {} is mostly a pouch", why);
  }
}

FactOrigin origin_of(const Capacity& capacity) {
  if (capacity.from == CapacityFrom::kTold) return FactOrigin::kTold;
  const bool assumed = capacity.from == CapacityFrom::kGivenCell || capacity.is_lower_bound();
  return assumed ? FactOrigin::kAssumed : FactOrigin::kMeasured;
}

void settle_mass(const ToldBody& told, double size, const CellParameters& like, CellBody& body) {
  body.mass = {.key = "mass_kg", .label = "mass", .unit = "kg", .source = {}};
  if (told.mass_kg) {
    body.mass.value = *told.mass_kg;
    body.mass.origin = FactOrigin::kTold;
    body.mass.source = "--mass";
  } else if (body.form) {
    body.mass.value = usual_mass_kg(*body.form);
    body.mass.source = fmt::format("{:g} kg/m3 for a {}", density(*body.form),
                                   body.form->is_cylinder() ? "round cell" : "pouch or can");
  } else {
    body.mass.value = like.mass_kg * size;
    body.mass.source = fmt::format("{} scaled by {}", like.name,
                                   body.capacity_is_lower_bound ? "what was drawn: the least" : "capacity");
  }
}

void settle_surface(const CellParameters& like, CellBody& body) {
  body.surface = {.key = "surface_area_m2", .label = "surface", .unit = "m2", .source = {}};
  if (body.form) {
    body.surface.value = body.form->surface_m2();
    body.surface.origin = body.form_origin;
    body.surface.source = body.form_origin == FactOrigin::kTold ? "all of it, by --size" : "all of it, of that form";
  } else {
    // Alike in form: the surface goes with the two-thirds power of the mass.
    body.surface.value = like.surface_area_m2 * std::pow(body.mass.value / like.mass_kg, 2.0 / 3.0);
    body.surface.source = fmt::format("{} scaled by mass", like.name);
  }
}

}  // namespace

std::string_view name_of(FactOrigin origin) {
  return origin == FactOrigin::kTold ? "told" : origin == FactOrigin::kMeasured ? "measured" : "assumed";
}

std::string CellBody::form_text() const { return form ? form->text() : "a pouch"; }

void CellBody::write_into(CellParameters& cell) const {
  cell.mass_kg = mass.value;
  cell.heat_capacity_j_per_kg_k = heat_capacity.value;
  cell.surface_area_m2 = surface.value;
  cell.convection_w_per_m2_k = convection.value;
  cell.surface_lag_s = surface_lag.value;
}

CellBody cell_body(const ToldBody& told, const Capacity& capacity,
                   const std::function<CellParameters(const std::string& name)>& shipped) {
  VOLTLAP_DEMAND(capacity.ah > 0.0 && std::isfinite(capacity.ah));
  CellBody body;
  body.capacity = {"capacity_ah", "capacity", "Ah", capacity.ah, origin_of(capacity), capacity_source(capacity)};
  body.capacity_is_lower_bound = capacity.is_lower_bound();
  settle_form(told, capacity, body);
  const CellParameters like = shipped(model_of(body.form, capacity.ah));
  VOLTLAP_DEMAND(like.capacity_ah > 0.0 && like.mass_kg > 0.0);
  settle_mass(told, capacity.ah / like.capacity_ah, like, body);
  settle_surface(like, body);
  const std::string as_like = "as " + like.name;
  body.heat_capacity = {.key = "heat_capacity_j_per_kg_k", .label = "heat capacity", .unit = "J/kg/K",
                        .value = like.heat_capacity_j_per_kg_k, .source = as_like};
  if (told.heat_capacity_j_per_kg_k) {
    body.heat_capacity.value = *told.heat_capacity_j_per_kg_k;
    body.heat_capacity.origin = FactOrigin::kTold;
    body.heat_capacity.source = "--heat-capacity";
  }
  body.convection = {.key = "convection_w_per_m2_k", .label = "convection", .unit = "W/m2/K",
                     .value = like.convection_w_per_m2_k,
                     .source = as_like + "; a car's own: battery.convection_w_per_m2_k"};
  body.surface_lag = {.key = "surface_lag_s", .label = "lag of its surface", .unit = "s",
                      .value = like.surface_lag_s, .source = as_like};
  VOLTLAP_DEMAND(body.mass.value > 0.0 && body.surface.value > 0.0 && body.heat_capacity.value > 0.0);
  return body;
}

double specific_energy_wh_per_kg(const CellParameters& cell) {
  VOLTLAP_DEMAND(cell.mass_kg > 0.0 && cell.ocv_soc.size() == cell.ocv_v.size());
  double mean_v = 0.0;
  for (std::size_t k = 1; k < cell.ocv_soc.size(); ++k)
    mean_v += 0.5 * (cell.ocv_v[k] + cell.ocv_v[k - 1]) * (cell.ocv_soc[k] - cell.ocv_soc[k - 1]);
  return cell.capacity_ah * mean_v / cell.mass_kg;
}

namespace {

constexpr double kBestWhPerLitre = 900.0;  // the best round cells of 2024 come to 800

double energy_wh_per_litre(const CellParameters& cell, const CellForm& form) {
  return specific_energy_wh_per_kg(cell) * cell.mass_kg / (1e3 * form.volume_m3());
}

}  // namespace

void require_possible_size(const CellParameters& cell, const CellBody& body) {
  constexpr double kImpossible = 2.0 * kBestWhPerLitre;
  if (!body.form || body.form_origin != FactOrigin::kTold) return;
  const double energy = energy_wh_per_litre(cell, *body.form);
  if (energy <= kImpossible) return;
  throw InputError("--size",
                   fmt::format("{:.4g} Ah in {} ({:.4g} cm3), {:.0f} Wh/L", cell.capacity_ah, body.form_text(),
                               1e6 * body.form->volume_m3(), energy),
                   fmt::format("at most about {:.0f} Wh/L of the best cells", kBestWhPerLitre),
                   "Check the unit of the current and of the time, --cells-in-parallel, and the size in mm");
}

std::vector<std::string> implausible(const CellParameters& cell, const CellBody& body) {
  constexpr double kDensityLow = 1500.0, kDensityHigh = 3500.0;  // kg/m3, of lithium-ion cells
  constexpr double kEnergyLow = 20.0, kEnergyHigh = 350.0;       // Wh/kg, of a capacitor's kin to the best of 2024
  std::vector<std::string> out;
  if (body.form) {
    const double kg_per_m3 = body.mass.value / body.form->volume_m3();
    if (kg_per_m3 < kDensityLow || kg_per_m3 > kDensityHigh) {
      out.push_back(fmt::format(
          "Implausible: {:.4g} kg ({}) in {:.4g} cm3 ({}) are {:.0f} kg/m3; cells have {:.0f} to {:.0f}. Check --mass, "
          "in kg, and --size, in mm.",
          body.mass.value, name_of(body.mass.origin), 1e6 * body.form->volume_m3(), name_of(body.form_origin),
          kg_per_m3, kDensityLow, kDensityHigh));
    }
  }
  if (body.form && energy_wh_per_litre(cell, *body.form) > kBestWhPerLitre) {
    out.push_back(fmt::format(
        "Implausible: {:.4g} Ah in {:.4g} cm3 ({}) are {:.0f} Wh/L; cells have up to {:.0f}. Check the unit of the "
        "current and of the time, --cells-in-parallel and --size.",
        cell.capacity_ah, 1e6 * body.form->volume_m3(), name_of(body.form_origin),
        energy_wh_per_litre(cell, *body.form), kBestWhPerLitre));
  }
  const double energy = specific_energy_wh_per_kg(cell);
  if ((energy < kEnergyLow && !body.capacity_is_lower_bound) || energy > kEnergyHigh) {
    out.push_back(fmt::format(
        "Implausible: {} Ah in {:.4g} kg ({}) are {:.0f} Wh/kg; cells have {:.0f} to {:.0f}. Check --mass, in kg, "
        "and --cells-in-parallel: the cell that is meant is the one that the capacity is of.",
        significant(cell.capacity_ah, 3), body.mass.value, name_of(body.mass.origin), energy, kEnergyLow,
        kEnergyHigh));
  }
  return out;
}

std::vector<CellFact> cell_facts(const CellParameters& cell, const CellBody& body, bool temperature_told) {
  constexpr FactOrigin kMeasured = FactOrigin::kMeasured;
  CellFact capacity = body.capacity;
  capacity.value = cell.capacity_ah;  // of several cells the mean
  return {capacity,
          {"voltage_min_v", "lowest voltage", "V", cell.voltage_min_v, kMeasured, "lowest in the recordings"},
          {"voltage_max_v", "highest voltage", "V", cell.voltage_max_v, kMeasured, "highest in the recordings"},
          body.mass,
          body.heat_capacity,
          body.surface,
          body.convection,
          body.surface_lag,
          {"reference_temperature_c", "temperature", "degC", cell.reference_temperature_c,
           temperature_told ? kMeasured : FactOrigin::kAssumed,
           temperature_told ? "of the recordings or --temperature" : "neither recorded nor told (--temperature)"},
          {"reference_current_a", "current", "A", cell.reference_current_a, kMeasured,
           "of the recordings; 0: several currents in one table"}};
}

std::string cell_facts_text(const CellParameters& cell, const CellBody& body, bool temperature_told) {
  std::string out = fmt::format("  form                 {} ({}: {})\n", body.form_text(), name_of(body.form_origin),
                                body.form_source);
  for (const CellFact& fact : cell_facts(cell, body, temperature_told)) {
    out += fmt::format("  {:<18} {:>9} {:<7} {:<9} {}\n", fact.label, short_number(fact.value), fact.unit,
                       name_of(fact.origin), fact.source);
  }
  std::string flags;
  for (const auto& [origin, flag] : {std::pair{body.mass.origin, "--mass"}, {body.form_origin, "--size"},
                                     {body.heat_capacity.origin, "--heat-capacity"}}) {
    if (origin == FactOrigin::kAssumed) flags += (flags.empty() ? "" : ", ") + std::string(flag);
  }
  if (flags.empty()) return out;
  return out + fmt::format("  What is assumed decides how warm the cell gets in a car; tell it with {}.\n", flags);
}

}  // namespace voltlap::plant
