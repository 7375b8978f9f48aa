# cmake -DFROM=FILE -DINTO=FOLDER -P place.cmake: put a library into a folder in one step
get_filename_component(name "${FROM}" NAME)
string(RANDOM LENGTH 12 suffix)
file(MAKE_DIRECTORY "${INTO}")
file(COPY "${FROM}" DESTINATION "${INTO}/.${suffix}")
file(RENAME "${INTO}/.${suffix}/${name}" "${INTO}/${name}")
file(REMOVE_RECURSE "${INTO}/.${suffix}")
