// SPDX-License-Identifier: MIT
// The part of PX4 that an exported module uses: a module that a test starts, runs and stops.
#pragma once

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define __EXPORT
#define MODULE_NAME "module"
#define PX4_OK 0
#define PX4_ERROR (-1)
#define PX4_ERR(...) (printf(__VA_ARGS__), printf("\n"))
#define PX4_WARN(...) PX4_ERR(__VA_ARGS__)
#define PX4_INFO(...) PX4_ERR(__VA_ARGS__)
#define PRINT_MODULE_DESCRIPTION(text) PX4_INFO("%s", text)
#define PRINT_MODULE_USAGE_NAME(name, kind) PX4_INFO("%s %s", name, kind)
#define PRINT_MODULE_USAGE_COMMAND(name) PX4_INFO("%s", name)
#define PRINT_MODULE_USAGE_DEFAULT_COMMANDS() PX4_INFO("stop, status")

static constexpr int task_id_is_work_queue = -2;

template <class T>
struct ShimAtomic {
  T* value = nullptr;
  void store(T* to) { value = to; }
  T* load() const { return value; }
};

template <class T>
class ModuleBase {
 public:
  virtual ~ModuleBase() = default;
  static int main(int argc, char* argv[]) {
    if (argc < 2) return T::print_usage();
    if (strcmp(argv[1], "start") == 0) return T::task_spawn(argc - 1, argv + 1);
    T* running = _object.load();
    if (strcmp(argv[1], "status") == 0) return running != nullptr ? running->print_status() : PX4_ERROR;
    if (strcmp(argv[1], "stop") != 0) return T::custom_command(argc - 1, argv + 1);
    if (running != nullptr) running->_exits = true;
    return PX4_OK;
  }
  virtual int print_status() = 0;

 protected:
  bool should_exit() const { return _exits; }
  static void exit_and_cleanup() {
    delete _object.load();
    _object.store(nullptr);
    _task_id = -1;
  }
  inline static ShimAtomic<T> _object;
  inline static int _task_id = -1;

 private:
  bool _exits = false;
};
