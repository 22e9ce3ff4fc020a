! The cells inside a surface, in the lower half of its box along z, from Fortran.
!
!   ./window part.stl 40 32 24

module hexcast
  use iso_c_binding
  implicit none

  interface
    function hexcast_mesher_new(options, error) bind(c)
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: options(*)
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_mesher_new
    end function

    function hexcast_mesh(mesher, job, facets, n_facets, error) bind(c)
      import :: c_ptr, c_char, c_size_t
      type(c_ptr), value :: mesher, facets
      character(kind=c_char), intent(in) :: job(*)
      integer(c_size_t), value :: n_facets
      type(c_ptr), intent(inout) :: error
      type(c_ptr) :: hexcast_mesh
    end function

    function hexcast_mesh_fill_box(mesh, first, end, flags, n_bytes, error) bind(c)
      import :: c_ptr, c_int32_t, c_int8_t, c_size_t
      type(c_ptr), value :: mesh
      integer(c_int32_t), intent(in) :: first(3), end(3)
      integer(c_int8_t), intent(out) :: flags(*)
      integer(c_size_t), value :: n_bytes
      type(c_ptr), intent(inout) :: error
      integer(c_int32_t) :: hexcast_mesh_fill_box
    end function

    function hexcast_error_message(error) bind(c)
      import :: c_ptr
      type(c_ptr), value :: error
      type(c_ptr) :: hexcast_error_message
    end function

    subroutine hexcast_mesh_free(mesh) bind(c)
      import :: c_ptr
      type(c_ptr), value :: mesh
    end subroutine

    subroutine hexcast_mesher_free(mesher) bind(c)
      import :: c_ptr
      type(c_ptr), value :: mesher
    end subroutine

    function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
      integer(c_size_t) :: strlen
    end function
  end interface

contains

  ! Prints an error and ends the program.
  subroutine fail(error)
    type(c_ptr), intent(in) :: error
    type(c_ptr) :: text
    character(kind=c_char), pointer :: letters(:)
    text = hexcast_error_message(error)
    call c_f_pointer(text, letters, [strlen(text)])
    print '(*(a))', letters
    stop 1
  end subroutine
end module

program window
  use hexcast
  implicit none
  type(c_ptr) :: mesher, mesh, error
  character(len=1024) :: file, job, number
  integer(c_int32_t) :: dims(3), own(3), axis
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
  if (.not. c_associated(mesher)) call fail(error)
  mesh = hexcast_mesh(mesher, trim(job)//c_null_char, c_null_ptr, 0_c_size_t, error)
  if (.not. c_associated(mesh)) call fail(error)

  ! flags are x fastest, as arrays of Fortran are; those above 127 are negative in 8 bits with a sign
  allocate (flags(own(1), own(2), own(3)))
  if (hexcast_mesh_fill_box(mesh, [0, 0, 0], own, flags, size(flags, kind=c_size_t), error) /= 0) call fail(error)
  print '(i0, a)', count(flags /= 0), ' cells inside'

  call hexcast_mesh_free(mesh)
  call hexcast_mesher_free(mesher)
end program
