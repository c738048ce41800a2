// SPDX-License-Identifier: MIT
// SimpleFOC's clock, as far as exported sensors ask for it; main.cpp and SimpleFOC.h drive it.
#pragma once

unsigned long _micros();
