// SPDX-License-Identifier: Apache-2.0
#include "race/limit_reason.hpp"

#include <iterator>
#include <set>

#include "ecu_words.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(LimitReason) {
  EcuWords car;

  std::string bound_by(can::TorqueReason torque, can::LimitReason discharge = can::LimitReason::kNone) {
    can::MasterStatus master;
    master.torque_reason = torque;
    can::BmsLimits limits;
    limits.discharge_reason = discharge;
    car.say(master, limits);
    return limit_reason_name(binding_limit_reason(car.ecus));
  }
};

TEST(LimitReason, TheBmssOwnReasonStandsForItsDischargeLimit) {
  STRCMP_EQUAL("cell_voltage", bound_by(can::TorqueReason::kDischargeLimit, can::LimitReason::kCellVoltage).c_str());
  STRCMP_EQUAL("soc_low", bound_by(can::TorqueReason::kDischargeLimit, can::LimitReason::kSocLow).c_str());
}

TEST(LimitReason, EveryReasonOfTheBmsHasItsOwnNameAndNoneOfTheMastersIsOneOfThem) {
  std::set<std::string> names;
  for (std::size_t k = 0; k < std::size(can::kLimitReasonNames); ++k) {
    names.insert(bound_by(can::TorqueReason::kDischargeLimit, static_cast<can::LimitReason>(k)));
  }
  STRCMP_EQUAL("energy_to_go", bound_by(can::TorqueReason::kDischargeLimit, can::LimitReason::kEnergyToGo).c_str());
  for (const can::TorqueReason torque : {can::TorqueReason::kChargeLimit, can::TorqueReason::kPower,
                                         can::TorqueReason::kTemperature, can::TorqueReason::kMotorSpeed}) {
    names.insert(bound_by(torque));
  }
  LONGS_EQUAL(kLimitReasons, names.size());
}

TEST(LimitReason, TheMastersReasonsFollowTheBmss) {
  STRCMP_EQUAL("charge_limit", bound_by(can::TorqueReason::kChargeLimit).c_str());
  STRCMP_EQUAL("power", bound_by(can::TorqueReason::kPower).c_str());
  STRCMP_EQUAL("motor_temperature", bound_by(can::TorqueReason::kTemperature).c_str());
}

TEST(LimitReason, NoLimitBindsWithoutOneAndBehindAClosedGate) {
  STRCMP_EQUAL("none", bound_by(can::TorqueReason::kNone, can::LimitReason::kCellVoltage).c_str());
  STRCMP_EQUAL("none", bound_by(can::TorqueReason::kGate).c_str());
}

TEST(LimitReason, ANumberBeyondAllReasonsIsUnknown) { STRCMP_EQUAL("unknown", limit_reason_name(kLimitReasons)); }
