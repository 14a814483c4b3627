// Catan in ILLIXR's phonebook: what the sources of plugins, compiled behind plugin_hooks.h, ask of the plugin `catan`.
// Where it was not loaded before them there is no such service, and they are as without Catan.
//
// C++17, as plugins are; nothing to link.
//
// Thread safety: all calls from any thread. What they return lives as long as the phonebook.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "common/local_hooks.h"
#include "illixr/phonebook.hpp"

namespace catan_illixr {

// A switchboard event, as its `event` base.
using Message = std::shared_ptr<const void>;

class Service : public ILLIXR::phonebook::service {
 public:
  // A plugin has been made.
  virtual void note_plugin(std::size_t id, const std::string& name) = 0;
  virtual catan_ros::TopicHook& topic(const std::string& name) = 0;
  // Of the plugin's threadloop, or of its callback for a topic, which `call` calls. Null: it is no node.
  virtual catan_ros::LoopHook* find_loop(std::size_t plugin) = 0;
  virtual catan_ros::CallbackHook* bind(std::size_t plugin, const std::string& topic,
                                        std::function<void(const Message&)> call) = 0;
};

}  // namespace catan_illixr
