// The plugin `catan` of ILLIXR. It must be the first of those that are loaded: the others look for its service when
// they are made, and the runtime stops it before them, so that none of them waits any more when it is stopped itself.
//
// Without CATAN_SOCKET and CATAN_ILLIXR_BINDINGS it registers nothing, and all is as without it.
#include <dlfcn.h>

#include <cstdlib>

#include "common/thread_hook.h"
#include "illixr/plugin.hpp"
#include "illixr/program.h"

namespace catan_illixr {
namespace {

using catan_ros::ServerConnection;

Program* g_program = nullptr;

// Whether threads that plugins make can be told of: the library is there where the program was started with it.
void hook_threads(bool hooked) {
  static const catan_ros::ThreadHook kHook{[] {
                                             const catan_ros::LocalNode* const node = catan_ros::LocalNode::current();
                                             return node != nullptr ? node->binding().node.c_str() : nullptr;
                                           },
                                           [](const char* node) { g_program->adopt_this_thread(node); }, nullptr};
  void* const found = ::dlsym(RTLD_DEFAULT, catan_ros::kSetThreadHook);
  if (found != nullptr) reinterpret_cast<catan_ros::SetThreadHook>(found)(hooked ? &kHook : nullptr);
}

class CatanPlugin final : public ILLIXR::plugin {
 public:
  CatanPlugin(const std::string& name, ILLIXR::phonebook* book) : plugin(name, book) {
    spdlogger(std::getenv("CATAN_LOG_LEVEL"));
    const char* const text = std::getenv(catan_ros::kIllixrBindingsVariable);
    if (text == nullptr || std::getenv("CATAN_SOCKET") == nullptr) return;
    auto bindings = catan_ros::parse_bindings(text);
    auto message_runs = catan_ros::MessageRuns::make();
    if (!bindings || !message_runs) {
      plugin_logger_->error("{} is not understood, or there is no memory; nothing is scheduled",
                            catan_ros::kIllixrBindingsVariable);
      return;
    }
    program_ = std::make_shared<Program>(std::move(*bindings), std::move(message_runs),
                                         [log = plugin_logger_](ServerConnection::Severity severity, const auto& said) {
                                           const bool error = severity == ServerConnection::Severity::kError;
                                           log->log(error ? spdlog::level::err : spdlog::level::warn, said);
                                         });
    book->register_impl<Service>(program_);
    g_program = program_.get();
    hook_threads(true);
    program_->start();
  }

  void stop() override {
    if (program_) {
      hook_threads(false);
      program_->stop();
    }
    plugin::stop();
  }

 private:
  std::shared_ptr<Program> program_;  // null: nothing is scheduled
};

}  // namespace
}  // namespace catan_illixr

extern "C" __attribute__((visibility("default"))) ILLIXR::plugin* this_plugin_factory(ILLIXR::phonebook* book) {
  return new catan_illixr::CatanPlugin("catan", book);
}
