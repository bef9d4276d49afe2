/* Stand-in: the task that ESP-IDF starts. */
void app_main(void);

int main(void) {
  app_main();
  return 0;
}
