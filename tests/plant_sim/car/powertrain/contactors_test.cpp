// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/contactors.hpp"

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Contactors) {
  ContactorSection section = vtm16e().contactors;
  ContactorBox box{section};

  void close_all() {
    for (Contactor* c : {&box.air_plus, &box.air_minus, &box.precharge}) c->command(true);
    for (int i = 0; i < 10; ++i) box.advance(0.01);
  }
};

TEST(Contactors, AContactorClosesAfterItsTravelTimeAndNotBefore) {
  box.air_plus.command(true);
  for (int ms = 0; ms < 19; ++ms) box.advance(0.001);
  CHECK_FALSE(box.air_plus.closed());
  for (int ms = 0; ms < 2; ++ms) box.advance(0.001);
  CHECK(box.air_plus.closed());
}

TEST(Contactors, AContactorOpensAfterItsOwnTravelTime) {
  close_all();
  box.air_plus.command(false);
  for (int ms = 0; ms < 9; ++ms) box.advance(0.001);
  CHECK(box.air_plus.closed());
  for (int ms = 0; ms < 2; ++ms) box.advance(0.001);
  CHECK_FALSE(box.air_plus.closed());
}

TEST(Contactors, ACommandTakenBackDuringTheTravelMovesNothing) {
  box.air_plus.command(true);
  for (int ms = 0; ms < 15; ++ms) box.advance(0.001);
  box.air_plus.command(false);
  box.advance(0.001);
  box.air_plus.command(true);
  for (int ms = 0; ms < 15; ++ms) box.advance(0.001);
  CHECK_FALSE(box.air_plus.closed());
}

TEST(Contactors, AWeldedContactorStaysClosedWhateverIsCommanded) {
  box.air_plus.set_fault(ContactorFault::kWelded);
  CHECK(box.air_plus.closed());
  box.air_plus.command(false);
  for (int i = 0; i < 10; ++i) box.advance(0.01);
  CHECK(box.air_plus.closed());
}

TEST(Contactors, AnOpenFaultKeepsAContactorOpen) {
  close_all();
  box.air_minus.set_fault(ContactorFault::kOpen);
  CHECK_FALSE(box.air_minus.closed());
  CHECK_FALSE(box.main_closed());
  DOUBLES_EQUAL(0.0, box.conductance(), 0.0);
}

TEST(Contactors, PathNeedsTheMinusSideAndOneOfTheOthers) {
  DOUBLES_EQUAL(0.0, box.conductance(), 0.0);
  box.precharge.command(true);
  for (int i = 0; i < 10; ++i) box.advance(0.01);
  DOUBLES_EQUAL(0.0, box.conductance(), 0.0);
  box.air_minus.command(true);
  for (int i = 0; i < 10; ++i) box.advance(0.01);
  DOUBLES_EQUAL(1.0 / 100.0, box.conductance(), 1e-12);
  close_all();
  DOUBLES_EQUAL(1.0 / 0.0005 + 1.0 / 100.0, box.conductance(), 1e-9);
  CHECK(box.main_closed());
}

TEST(Contactors, ABrokenPrechargeResistorConductsNothing) {
  box.precharge_resistor_open = true;
  box.precharge.command(true);
  box.air_minus.command(true);
  for (int i = 0; i < 10; ++i) box.advance(0.01);
  DOUBLES_EQUAL(0.0, box.conductance(), 0.0);
}
