// SPDX-License-Identifier: Apache-2.0
#include "explain/extend/race_change.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kCar = "vtm16e";
constexpr const char* kCourse = "michigan_2015";

/// The last difference between the BMS's SOC and the car's.
class SocWatch : public EnduranceObserver {
 public:
  SocWatch(const RaceTools& tools, std::string doing, double from)
      : tools_(tools), doing_(std::move(doing)), from_(from) {}

  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample& sample) override { error_pct = 100.0 * (sample.bms_soc - sample.soc); }
  void on_progress(double fraction, double) override {
    constexpr double kRaces = 3.0;
    if (tools_.progress) tools_.progress(doing_, from_ + std::max(0.0, fraction) / kRaces);
  }
  [[nodiscard]] bool stop_requested() override { return tools_.stop_requested && tools_.stop_requested(); }

  double error_pct = 0.0;

 private:
  const RaceTools& tools_;
  std::string doing_;
  double from_;
};

/// The car that the model drives in.
VehicleParameters car_around(const Model& model, const VehicleParameters& of_model,
                             const VehicleParameters& standard, std::string& words) {
  if (model.kind == ModelKind::kVehicle) {
    words = of_model.name;
    return of_model;
  }
  if (model.kind == ModelKind::kPack) {
    VehicleParameters car = of_model;
    car.tyres.radius_m = standard.tyres.radius_m;
    words = fmt::format("{} with the pack of {}", standard.name, of_model.name);
    return car;
  }
  VehicleParameters car = standard;
  car.cell = of_model.cell;
  car.battery.capacity_ah = car.cell.capacity_ah;
  car.battery.convection_w_per_m2_k = car.cell.convection_w_per_m2_k;
  const double pack_ah = standard.cell.capacity_ah * standard.battery.cells_in_parallel;
  // As many for the extended cell as for the given one: the pack is the same pack.
  car.battery.cells_in_parallel =
      std::max(1, static_cast<int>(std::lround(pack_ah / model.world.car.cell.capacity_ah)));
  words = fmt::format("{} with {} in series and {} in parallel of the cell {}", standard.name,
                      car.battery.cells_in_series, car.battery.cells_in_parallel, of_model.cell.name);
  return car;
}

RacePrediction drive(const VehicleParameters& car, const VehicleParameters& bms, const Track& track, int laps,
                     const RaceTools& tools, SocWatch&& watch) {
  EnduranceOptions options;
  options.vehicle = car;
  options.track = track;
  options.laps = laps;
  const std::unique_ptr<Ecus> ecus = tools.firmware(bms);
  RacePrediction out;
  out.result = run_endurance(options, *ecus, watch);
  out.bms_soc_error_end_pct = watch.error_pct;
  return out;
}

}  // namespace

RaceChange race_change(const DataFolder& data, const Model& model, const World& extended, const RaceTools& tools) {
  RaceChange out;
  try {
    const VehicleParameters standard = load_vehicle(data, kCar, {}).parameters;
    ExtendedCar changed = extended_car(model.world, extended);
    out.left_out = changed.left_out;
    const VehicleParameters before = car_around(model, model.world.car, standard, out.car);
    VehicleParameters after = car_around(model, changed.car, standard, out.car);
    const double warmer = extended.car.environment.ambient_c - model.world.car.environment.ambient_c;
    if (model.kind == ModelKind::kCell) after.environment.ambient_c += warmer;
    const BatterySection &given = model.world.car.battery, &found = changed.car.battery;
    const bool in_pack = found.contact_resistance_ohm != given.contact_resistance_ohm || !found.cells.empty();
    if (model.kind == ModelKind::kCell && in_pack) {
      out.left_out.emplace_back("contacts and single cells (the model is a cell file)");
    }
    const Track track = load_track(data.find("tracks", kCourse, "--track"));
    out.laps = laps_of_endurance(track);
    out.course = track.name;
    out.before =
        drive(before, before, track, out.laps, tools, SocWatch(tools, "driving the endurance with the model", 0.0));
    out.after_old_bms =
        drive(after, before, track, out.laps, tools, SocWatch(tools, "with the extended model", 1.0 / 3.0));
    out.after =
        drive(after, after, track, out.laps, tools, SocWatch(tools, "with the extended model and BMS", 2.0 / 3.0));
    out.stopped = out.before.result.stopped || out.after_old_bms.result.stopped || out.after.result.stopped;
  } catch (const InputError& error) {
    out.impossible = error.what();
  }
  return out;
}

}  // namespace voltlap::plant
