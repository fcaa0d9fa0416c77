# SPDX-License-Identifier: Apache-2.0
# These tests need vcan0 and vcan1: `./voltlap with-vcan`. They never skip: without the interfaces they fail.
pytest_plugins = ["voltlap_hil.pytest_plugin"]
