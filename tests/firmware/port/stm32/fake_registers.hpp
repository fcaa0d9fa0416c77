// SPDX-License-Identifier: Apache-2.0
// Registers that behave: the tests link this in the place of port/stm32/register.cpp. A block of registers belongs to a
// model, which is asked for every read and told of every write; what belongs to none is plain memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>

namespace voltlap::port::stm32::test {

/// The power has gone: thrown out of a register access, caught where the test restarts.
struct PowerLost {};

class Model {
 public:
  virtual std::uint32_t read(std::size_t offset) = 0;
  virtual void write(std::size_t offset, std::uint32_t value) = 0;

 protected:
  ~Model() = default;
};

/// Accesses to [first, first + bytes) go to `model` while this lives.
class Attached {
 public:
  Attached(const void* first, std::size_t bytes, Model& model);
  ~Attached();
  Attached(const Attached&) = delete;
  Attached& operator=(const Attached&) = delete;

 private:
  const void* first_;
};

/// What wait_for_interrupt does; nothing unless set.
void on_wait_for_interrupt(std::function<void()> what);

}  // namespace voltlap::port::stm32::test
