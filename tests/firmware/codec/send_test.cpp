// SPDX-License-Identifier: Apache-2.0
#include "codec/send.hpp"

#include "CppUTest/TestHarness.h"
#include "can_dbc/car.hpp"

using namespace voltlap;

TEST_GROUP(Send){};

TEST(Send, MessageIsEncodedSealedAndQueued) {
  codec::Sealer sealer;
  TxQueue tx;
  can::ContactorCommand command;
  command.air_minus_close = true;
  codec::send(command, sealer, tx);
  codec::send(command, sealer, tx);
  LONGS_EQUAL(2, static_cast<long>(tx.size()));
  LONGS_EQUAL(1, codec::counter_of(tx[1]));
  can::ContactorCommand back;
  CHECK(codec::sealed_ok(tx[1]) && decode(tx[1], back));
  CHECK(back.air_minus_close && !back.air_plus_close);
}
