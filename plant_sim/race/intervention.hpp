// SPDX-License-Identifier: Apache-2.0
// What a harness does to the plant: pedals and switches instead of the driver's, and faults of parts and instruments.
#pragma once
#include "can_dbc/lockstep.hpp"
#include "car/car.hpp"
#include "race/sensors/sensor_frames.hpp"

namespace voltlap::plant {

/// Field by field; what is left automatic stays the driver's.
void override_pedals(const can::DriverOverride& by, Pedals& pedals);
void override_switches(const can::DriverOverride& by, Switches& switches);

/// Adds one fault, or clears all. False, and nothing happens, when the car has no such part.
[[nodiscard]] bool apply_plant_fault(const can::PlantFault& fault, Car& car, SensorFaults& sensors);

}  // namespace voltlap::plant
