// SPDX-License-Identifier: Apache-2.0
// The main function that all CppUTest suites share.
#include <CppUTest/CommandLineTestRunner.h>
#include <CppUTest/MemoryLeakWarningPlugin.h>

int main(int argc, char** argv) {
  // Standard containers and the C library cache memory between tests; leaks are the address sanitizer's job.
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return CommandLineTestRunner::RunAllTests(argc, argv);
}
