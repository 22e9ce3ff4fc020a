! The cells inside a surface, in the lower half of its box along z, from Fortran.
!
!   ./window part.stl 40 32 24

program window
  use hexcast
  implicit none
  type(c_ptr) :: mesher, mesh, error
  character(len=1024) :: file, job, number
  integer(c_int32_t) :: dims(3), own(3), axis
  type(hexcast_facets) :: none(0)
  integer(c_int8_t), allocatable :: flags(:, :, :)

  call get_command_argument(1, file)
  do axis = 1, 3
    call get_command_argument(1 + axis, number)
    read (number, *) dims(axis)
  end do
  own = [dims(1), dims(2), dims(3) / 2]
  write (job, '(3a, 2(i0, a), i0, a, 5(i0, a), i0, a)') '{"geometries": [{"file": "', trim(file), '"}], "dims": [', &
    dims(1), ',', dims(2), ',', dims(3), '], "window": [', 0, ',', 0, ',', 0, ',', own(1), ',', own(2), ',', own(3), ']}'

  error = c_null_ptr
  mesher = hexcast_mesher_new('{"backend": "cpu"}'//c_null_char, error)
  if (.not. c_associated(mesher)) call fail
  mesh = hexcast_mesh(mesher, trim(job)//c_null_char, none, 0_c_size_t, error)
  if (.not. c_associated(mesh)) call fail

  ! flags are x fastest, as arrays of Fortran are; those above 127 are negative in 8 bits with a sign
  allocate (flags(own(1), own(2), own(3)))
  if (hexcast_mesh_fill_box(mesh, [0, 0, 0], own, flags, size(flags, kind=c_size_t), error) /= 0) call fail
  print '(i0, a)', count(flags /= 0), ' cells inside'

  call hexcast_mesh_free(mesh)
  call hexcast_mesher_free(mesher)

contains

  ! Prints an error and ends the program.
  subroutine fail
    print '(a)', hexcast_text(hexcast_error_message(error))
    call hexcast_error_free(error)
    stop 1
  end subroutine
end program
