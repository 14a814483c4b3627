// The ILLIXR program that the plugin `catan` is loaded into: its connection to the server, and which of its plugins'
// threadloops and callbacks are nodes (common/binding.h).
//
// Thread safety: as Service says; start() and stop() by the thread that starts and stops plugins.
#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/binding.h"
#include "common/local_callback.h"
#include "common/local_loop.h"
#include "common/local_topic.h"
#include "common/message_runs.h"
#include "common/server_connection.h"
#include "illixr/service.h"

namespace catan_illixr {

class Program final : public Service {
 public:
  // `message_runs` is not null.
  Program(std::vector<catan_ros::Binding> bindings, std::unique_ptr<catan_ros::MessageRuns> message_runs,
          catan_ros::ServerConnection::Tell tell);
  ~Program() override { stop(); }

  // Looks for a server, and waits a moment for it, so that no loop goes round before. There may be one later, too.
  void start();
  // Ends runs and waits; lets callbacks that are under way return.
  void stop();

  void adopt_this_thread(const std::string& node) { connection_.adopt_this_thread(node); }

  void note_plugin(std::size_t id, const std::string& name) override;
  catan_ros::TopicHook& topic(const std::string& name) override { return find_topic(name); }
  catan_ros::LoopHook* find_loop(std::size_t plugin) override;
  catan_ros::CallbackHook* bind(std::size_t plugin, const std::string& topic,
                                std::function<void(const Message&)> call) override;

 private:
  catan_ros::LocalTopic& find_topic(const std::string& name);
  const catan_ros::Binding* find(std::size_t plugin, catan_ros::Binding::Kind kind, const std::string& topic) const;

  const std::vector<catan_ros::Binding> bindings_;
  const std::unique_ptr<catan_ros::MessageRuns> message_runs_;
  const catan_ros::ServerConnection::Tell tell_;
  catan_ros::ServerConnection connection_;
  std::atomic<bool> stopped_{false};
  std::thread connecting_;

  std::mutex mutex_;
  std::map<std::size_t, std::string> plugins_;
  std::map<std::string, catan_ros::LocalTopic> topics_;
  std::deque<catan_ros::LocalLoop> loops_;
  std::deque<catan_ros::LocalCallback> callbacks_;
};

}  // namespace catan_illixr
