// SPDX-License-Identifier: Apache-2.0
#include "fixtures.hpp"

#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "core/parameter_file.hpp"

namespace voltlap::plant::test {

VehicleParameters vtm16e() {
  static const VehicleParameters car = load_vehicle(DataFolder(VOLTLAP_DATA_DIR), "vtm16e").parameters;
  return car;
}

VehicleParameters amk_4wd() {
  static const VehicleParameters car = load_vehicle(DataFolder(VOLTLAP_DATA_DIR), "amk_4wd").parameters;
  return car;
}

VehicleParameters lossy_vtm16e() {
  VehicleParameters p = vtm16e();
  p.motor.efficiency = 0.9;
  p.motor.winding_loss = true;
  p.powertrain.driveline_efficiency = 0.9;
  p.inverter.efficiency = 0.95;
  return p;
}

CellParameters constant_cell() {
  CellParameters c = vtm16e().cell;
  c.name = "constant";
  c.soc_breakpoints = {0.5};
  c.temperature_breakpoints_c = {30.0};
  c.current_breakpoints_a = {100.0};
  c.ocv_polynomial_v = {3.7};
  c.r0_ohm = {{0.0012}, 0.0, 0.0, {}};
  c.branches[0].r_ohm = {{0.0004}, 0.0, 0.0, {}};
  c.branches[1].r_ohm = {{0.0008}, 0.0, 0.0, {}};
  c.branches[0].tau_s = {{33.0}, 0.0, 0.0, {}};
  c.branches[1].tau_s = {{161.0}, 0.0, 0.0, {}};
  return c;
}

std::vector<CellParameterMap*> resistances_of(CellParameters& cell) {
  std::vector<CellParameterMap*> out{&cell.r0_ohm};
  for (std::size_t k = 0; k < cell.branch_count(); ++k) out.push_back(&cell.branches[k].r_ohm);
  return out;
}

std::vector<CellParameterMap*> maps_of(CellParameters& cell) {
  std::vector<CellParameterMap*> out = resistances_of(cell);
  for (std::size_t k = 0; k < cell.branch_count(); ++k) out.push_back(&cell.branches[k].tau_s);
  return out;
}

Track michigan(int year) {
  return load_track(std::string(VOLTLAP_DATA_DIR "/tracks/michigan_") + std::to_string(year) + ".csv");
}

TemporaryFile::TemporaryFile(const std::string& name, const std::string& text)
    : path_((std::filesystem::temp_directory_path() / ("voltlap_" + std::to_string(::getpid()) + "_" + name))
                .string()) {
  std::ofstream(path_) << text;
}

TemporaryFile::~TemporaryFile() { std::filesystem::remove(path_); }

}  // namespace voltlap::plant::test
