/* Stand-in. */
#ifndef ESP_LOG_H
#define ESP_LOG_H
__attribute__((format(printf, 3, 4))) void stub_log(char level, const char* tag, const char* format, ...);
#define ESP_LOGE(tag, format, ...) stub_log('E', tag, format, ##__VA_ARGS__)
#define ESP_LOGI(tag, format, ...) stub_log('I', tag, format, ##__VA_ARGS__)
#endif
