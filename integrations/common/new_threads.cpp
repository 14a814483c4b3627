#include "common/new_threads.h"

#include <memory>

#include "common/middleware_threads.h"

namespace catan_ros {
namespace {

void* run_hooked_thread(void* todo_of_thread) {
  const NewThread todo = *std::unique_ptr<NewThread>(static_cast<NewThread*>(todo_of_thread));
  todo.hook(todo.node);
  return todo.function(todo.argument);
}

}  // namespace

int create_hooked_thread(CreateThread create, pthread_t* thread, const pthread_attr_t* attributes,
                         const NewThread& todo) {
  auto owned = std::make_unique<NewThread>(todo);
  const int result = create(thread, attributes, run_hooked_thread, owned.get());
  if (result == 0) static_cast<void>(owned.release());
  return result;
}

int create_thread(CreateThread create, pthread_t* thread, const pthread_attr_t* attributes, const NewThread& of_node,
                  bool may_be_middlewares) {
  // Also in a node's run: the first one to need the middleware's thread has it made.
  if (may_be_middlewares && makes_middleware_thread()) {
    const NewThread of_all{of_node.function, of_node.argument, note_middleware_thread, nullptr};
    return create_hooked_thread(create, thread, attributes, of_all);
  }
  if (of_node.node != nullptr) return create_hooked_thread(create, thread, attributes, of_node);
  return create(thread, attributes, of_node.function, of_node.argument);
}

}  // namespace catan_ros
