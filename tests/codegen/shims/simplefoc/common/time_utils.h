// SPDX-License-Identifier: MIT
// The part of SimpleFOC's clock that exported sensors use; main.cpp and SimpleFOC.h drive it.
#pragma once

unsigned long _micros();
