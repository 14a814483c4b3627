/* A node in C, in a process of its own, whose runs the main thread begins and ends. */
#include <catan/catan.h>
#include <stdio.h>
#include <time.h>

/* Computes for two milliseconds, in the place of real work. */
static void work(void) {
  const clock_t end = clock() + CLOCKS_PER_SEC / 500;
  while (clock() < end) {
  }
}

static int fail(catan_error* error) {
  fprintf(stderr, "node: %s\n", catan_error_message(error));
  catan_error_free(error);
  return 1;
}

int main(void) {
  catan_error* error = NULL;
  catan_client* client = catan_client_connect(NULL, &error);
  if (client == NULL) return fail(error);
  if (catan_client_start(client, &error) != CATAN_OK) return fail(error);
  catan_node* node = catan_client_attach(client, "detect", &error);
  if (node == NULL) return fail(error);
  while (catan_node_wait(node)) { /* until the process is ended */
    catan_run* run = catan_node_begin(node);
    work();
    if (catan_run_number(run) % 10 == 0) catan_run_skip_output(run); /* nothing found */
    catan_node_end(node);
  }
  catan_client_free(client);
  return 0;
}
