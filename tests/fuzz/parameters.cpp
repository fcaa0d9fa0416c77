// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"
#include "core/parameter_file.hpp"
#include "core/parameter_source.hpp"
#include "core/parameter_table.hpp"
#include "fuzz/target.hpp"
#include "learn/bench/plan_file.hpp"

namespace voltlap::plant {
namespace {

const DataFolder kData{VOLTLAP_SOURCE_DIR "/plant_sim/data"};

void check(const CellParameters& cell) {
  const CellTables tables(cell);
  for (const double soc : {0.0, 0.37, 1.0}) {
    const CircuitParameters circuit = tables.circuit(soc, 31.0, 12.0);
    VOLTLAP_DEMAND(std::isfinite(circuit.r0_ohm) && std::isfinite(circuit.tau_s[0]));
    VOLTLAP_DEMAND(std::isfinite(tables.ocv(soc).voltage_v) && std::isfinite(tables.ocv(soc).slope_v));
  }
}

void check(const LoadedVehicle& car) {
  VOLTLAP_DEMAND(!parameter_values(car.parameters).empty() && !parameter_sources(car).empty());
  check(car.parameters.cell);
}

}  // namespace

void read_vehicle(const std::string& path) { check(load_vehicle(kData, path)); }

void read_cell(const std::string& path) { check(load_cell(kData, path, "--cell")); }

/// Lines as --set has them.
void read_settings(const std::string& path) {
  std::istringstream text(content_of(path));
  std::vector<std::string> settings;
  for (std::string line; std::getline(text, line);) settings.push_back(line);
  check(load_vehicle(kData, "vtm16e", settings));
}

void read_plan(const std::string& path) { VOLTLAP_DEMAND(!load_plan(kData, path).name.empty()); }

}  // namespace voltlap::plant
